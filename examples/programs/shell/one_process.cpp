#include "processes.hpp"

namespace tapestry::shell {
ProcessPlace join_processes() { return {}; }
void share_bytes(void* /*bytes*/, int /*count*/) {}
void gather_bytes(const void* /*own*/, int /*count*/, void* /*all*/) {}
void abandon_processes(int /*exit_code*/) {}
void leave_processes() {}
}  // namespace tapestry::shell

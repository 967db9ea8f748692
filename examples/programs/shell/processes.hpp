#pragma once
#include <cstddef>

/// \file Functions of MPI for ranks.hpp: mpi_processes.cpp, or else one_process.cpp. No other object of a
/// program depends on whether MPI is there.

namespace tapestry::shell {
/// Place of this process among those that mpirun has started together.
struct ProcessPlace {
  std::size_t count = 1;
  std::size_t index = 0;
};

/// Joins the processes that mpirun has started with this one. The first call of these functions.
[[nodiscard]] ProcessPlace join_processes();

/// Overwrites the bytes with process 0's.
void share_bytes(void* bytes, int count);

/// Bytes of all processes, one behind the other.
void gather_bytes(const void* own, int count, void* all);

void abandon_processes(int exit_code);

/// Leaves the other processes, before this one ends.
void leave_processes();
}  // namespace tapestry::shell

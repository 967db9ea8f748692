#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <cstdlib>

#include "processes.hpp"

namespace tapestry::shell {
ProcessPlace join_processes() {
  if (std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr && std::getenv("PMI_SIZE") == nullptr) return {};
  MPI_Init(nullptr, nullptr);
  int count = 1, index = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &count);
  MPI_Comm_rank(MPI_COMM_WORLD, &index);
  return {static_cast<std::size_t>(count), static_cast<std::size_t>(index)};
}

void share_bytes(void* bytes, int count) { MPI_Bcast(bytes, count, MPI_BYTE, 0, MPI_COMM_WORLD); }

void gather_bytes(const void* own, int count, void* all) {
  MPI_Allgather(own, count, MPI_BYTE, all, count, MPI_BYTE, MPI_COMM_WORLD);
}

void abandon_processes(int exit_code) { MPI_Abort(MPI_COMM_WORLD, exit_code); }

void leave_processes() {
  int is_open = 0;
  MPI_Initialized(&is_open);
  if (is_open != 0) MPI_Finalize();
}
}  // namespace tapestry::shell

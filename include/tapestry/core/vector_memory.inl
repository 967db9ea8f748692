// Vectors of one instruction set, in registers and in memory. Kernels include this file inside the namespace
// of each set: generic vectors must be parsed under the target they are meant for.
#ifndef TAPESTRY_VECTOR_BYTES  // an editor reads this file alone
#include <cstddef>
#define TAPESTRY_VECTOR_BYTES 16
#endif

template <class T>
struct Vector {
  static constexpr std::size_t lanes = TAPESTRY_VECTOR_BYTES / sizeof(T);
  typedef T Register __attribute__((vector_size(TAPESTRY_VECTOR_BYTES)));
  typedef T Memory __attribute__((vector_size(TAPESTRY_VECTOR_BYTES), aligned(sizeof(T)), may_alias));
};

template <class T>
using Register = typename Vector<T>::Register;

/// The vector that begins at `values`, aligned as a T. A value and never a reference: through a returned
/// reference clang 13 to 16 expect the alignment of a whole vector.
template <class T>
inline Register<T> load(const T* values) {
  return *reinterpret_cast<const typename Vector<T>::Memory*>(values);
}

/// Rows of two vectors whose sums stay in registers, beside what is added to them.
#if TAPESTRY_VECTOR_BYTES == 64
inline constexpr int tile_rows = 12;
#elif defined(__aarch64__)
inline constexpr int tile_rows = 10;
#else
inline constexpr int tile_rows = 6;
#endif

template <class T>
inline void store(T* values, const Register<T>& value) {
  *reinterpret_cast<typename Vector<T>::Memory*>(values) = value;
}

// Lanes of a vector that are used, for one instruction set: their signs, loads and stores.
#include <tapestry/core/vector_memory.inl>
#include <tapestry/nn/detail/vector_kernels.hpp>
using namespace tapestry::nn;  // where an editor reads this file alone

/// 2^i in lane i.
template <std::floating_point T>
inline typename Vector<ElementIndex<T>>::Register lane_bits() {
  using Lanes = typename Vector<ElementIndex<T>>::Register;
  if constexpr (Vector<T>::lanes == 16) {
    return Lanes{1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
  } else if constexpr (Vector<T>::lanes == 8) {
    return Lanes{1, 2, 4, 8, 16, 32, 64, 128};
  } else if constexpr (Vector<T>::lanes == 4) {
    return Lanes{1, 2, 4, 8};
  } else {
    return Lanes{1, 2};
  }
}

/// Bit i: whether x[i] is above 0.
#if TAPESTRY_VECTOR_BYTES == 64
inline std::uint16_t positive_lanes(const Register<float>& x) {
  return static_cast<std::uint16_t>(__builtin_ia32_cmpps512_mask(x, Register<float>{}, 30, 0xffff, 4));
}
inline std::uint8_t positive_lanes(const Register<double>& x) {
  return static_cast<std::uint8_t>(__builtin_ia32_cmppd512_mask(x, Register<double>{}, 30, 0xff, 4));
}
#else
template <class R>
inline std::uint8_t positive_lanes(const R& x) {
  const R zero = {};
  const auto is_positive = x > zero;
#if TAPESTRY_VECTOR_BYTES == 32
  if constexpr (sizeof(x[0]) == 4)
    return static_cast<std::uint8_t>(__builtin_ia32_movmskps256((R)is_positive));
#endif
  unsigned bits = 0;
  for (std::size_t lane = 0; lane < sizeof(x) / sizeof(x[0]); ++lane)
    bits |= is_positive[lane] != 0 ? 1U << lane : 0U;
  return static_cast<std::uint8_t>(bits);
}
#endif

template <class R>
inline void write_signs(const R& value, std::uint8_t* bits) {
  const auto signs = positive_lanes(value);
  __builtin_memcpy(bits, &signs, sizeof(signs));
}

/// value · slope in the lanes whose bit is not set; `bits` holds one vector's bits, or a byte.
template <std::floating_point T>
inline Register<T> gated(const std::uint8_t* bits, const Register<T>& value, T slope) {
  using Lanes = typename Vector<ElementIndex<T>>::Register;
  using Word = std::conditional_t<Vector<T>::lanes == 16, std::uint16_t, std::uint8_t>;
  Word word;
  __builtin_memcpy(&word, bits, sizeof(word));
  return ((Lanes{} + static_cast<ElementIndex<T>>(word)) & lane_bits<T>()) != 0 ? value : value * slope;
}

/// Copies `count` < lanes values of a vector; most often half of them.
template <class Element>
inline void copy_lanes(const Element* from, Element* to, std::size_t count) {
  if (count == Vector<Element>::lanes / 2) {
    __builtin_memcpy(to, from, TAPESTRY_VECTOR_BYTES / 2);
  } else {
    __builtin_memcpy(to, from, count * sizeof(Element));
  }
}

#if TAPESTRY_VECTOR_BYTES == 64
/// The instruction set loads and stores a part of a vector as fast as a whole one.
inline constexpr bool has_masks = true;

/// Writes `count` leading values, or all that there are.
template <class Element>
inline void store_lanes(const Register<Element>& value, Element* out, std::size_t count) {
  const unsigned mask = count >= Vector<Element>::lanes ? 0xffffU : (1U << count) - 1U;
  if constexpr (sizeof(Element) == 4) {
    __builtin_ia32_storeups512_mask(reinterpret_cast<float*>(out), (Register<float>)value,
                                    static_cast<unsigned short>(mask));
  } else {
    __builtin_ia32_storeupd512_mask(reinterpret_cast<double*>(out), (Register<double>)value,
                                    static_cast<unsigned char>(mask));
  }
}

/// Reads `count` leading values, or all that there are; the others are 0.
template <std::floating_point T>
inline Register<T> load_lanes(const T* in, std::size_t count) {
  const unsigned mask = count >= Vector<T>::lanes ? 0xffffU : (1U << count) - 1U;
  if constexpr (sizeof(T) == 4) {
    return __builtin_ia32_loadups512_mask(in, Register<T>{}, static_cast<unsigned short>(mask));
  } else {
    return __builtin_ia32_loadupd512_mask(in, Register<T>{}, static_cast<unsigned char>(mask));
  }
}
#else
inline constexpr bool has_masks = false;

template <class Element>
inline void store_lanes(const Register<Element>& value, Element* out, std::size_t count) {
  if (count >= Vector<Element>::lanes) {
    store(out, value);
    return;
  }
  Element partial[Vector<Element>::lanes];
  store(&partial[0], value);
  copy_lanes(&partial[0], out, count);
}

template <std::floating_point T>
inline Register<T> load_lanes(const T* in, std::size_t count) {
  if (count >= Vector<T>::lanes) return load(in);
  T partial[Vector<T>::lanes] = {};
  copy_lanes(in, &partial[0], count);
  return load(&partial[0]);
}
#endif

// Pairs of bfloat16 of one instruction set. A word, stored as a float is, holds two of them, the first one in
// its low half; see bfloat16.hpp. Where TAPESTRY_BFLOAT16 is defined the processor has instructions for them,
// elsewhere the same arithmetic is done in float: the product of two bfloat16 is exact, so that the order of
// the sum alone decides its bits.
#include <tapestry/nn/detail/pointwise_kernels.inl>

using Bits = std::uint32_t;
using Words = Register<Bits>;
typedef std::uint16_t Halves __attribute__((vector_size(TAPESTRY_VECTOR_BYTES / 2)));
typedef std::uint16_t HalvesMemory
    __attribute__((vector_size(TAPESTRY_VECTOR_BYTES / 2), aligned(2), may_alias));

inline Words load_words(const float* words) {
  return *reinterpret_cast<const typename Vector<Bits>::Memory*>(words);
}
inline void store_words(float* to, const Words& words) {
  *reinterpret_cast<typename Vector<Bits>::Memory*>(to) = words;
}

#if !defined(TAPESTRY_BFLOAT16)
/// The nearest bfloat16 in the high half of each lane, ties to even; below it, the rest of the sum.
/// Subnormals become zeros and NaN stays NaN.
inline Words rounded(const Register<float>& values) {
  const Words bits = reinterpret_cast<Words>(values);
  const Words magnitude = bits & 0x7fffffffU;
  const Words nearest = bits + 0x7fffU + ((bits >> 16) & 1U);
  const Words normal = magnitude > 0x7f800000U ? bits | 0x400000U : nearest;
  return magnitude < 0x00800000U ? bits & 0x80000000U : normal;
}
#endif

/// Lane by lane the pair of `first` and `second`.
inline Words pairs_of(const Register<float>& first, const Register<float>& second) {
#if defined(TAPESTRY_BFLOAT16)
  const auto both = reinterpret_cast<__m512i>(_mm512_cvtne2ps_pbh(second, first));
  const __m512i order = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8, 23, 7,
                                         22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
  return reinterpret_cast<Words>(_mm512_permutexvar_epi16(order, both));
#else
  return (rounded(second) & 0xffff0000U) | (rounded(first) >> 16);
#endif
}

/// Neighbouring lanes as pairs, half a register of them.
inline void store_neighbours(float* to, const Register<float>& values) {
#if defined(TAPESTRY_BFLOAT16)
  const Halves halves = reinterpret_cast<Halves>(_mm512_cvtneps_pbh(values));
#else
  const Halves halves = __builtin_convertvector(rounded(values) >> 16, Halves);
#endif
  *reinterpret_cast<HalvesMemory*>(to) = halves;
}

/// One step of a reduction: adds the second product of a pair, then the first one.
struct PairProduct {
  __attribute__((always_inline)) static inline Words weight(const float* weights) {
    return load_words(weights);
  }
  __attribute__((always_inline)) static inline Register<float> added(Register<float> sum, Words weight,
                                                                     const float* in) {
    Bits pair;
    __builtin_memcpy(&pair, in, sizeof pair);
#if defined(TAPESTRY_BFLOAT16)
    __m512i pairs = _mm512_set1_epi32(static_cast<int>(pair));
#if defined(__clang__) && __clang_major__ == 16
    asm("" : "+v"(pairs));  // without it the compiler's back end never finishes
#endif
    return _mm512_dpbf16_ps(sum, reinterpret_cast<__m512bh>(weight), reinterpret_cast<__m512bh>(pairs));
#else
    const Bits first_bits = pair << 16, second_bits = pair & 0xffff0000U;
    float first, second;
    __builtin_memcpy(&first, &first_bits, sizeof first);
    __builtin_memcpy(&second, &second_bits, sizeof second);
    sum = sum + reinterpret_cast<Register<float> >(weight & 0xffff0000U) * second;
    return sum + reinterpret_cast<Register<float> >(weight << 16) * first;
#endif
  }
};

// Epilogues of sums before they are stored, for one instruction set; vector_kernels.inl includes this
// file, under the same rules. See Epilogue for the definition.

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

/// value · slope in the lanes whose bit is not set; `bits` are those of one vector, or of a byte.
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

#include <tapestry/nn/detail/curve_kernels.inl>

/// The general form of store_tile(), for any epilogue. It is a function of its own, not inlined into every
/// kernel, so that compilers stay quick.
template <std::floating_point T>
__attribute__((noinline)) void store_any(const Epilogue<T>& from, const Register<T>* sums, std::size_t rows,
                                         std::size_t registers, std::size_t first, T* out,
                                         std::ptrdiff_t step, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  const Epilogue<T> end = from;  // a copy, which stores cannot change
  for (std::size_t row = 0; row < rows; ++row, out += step, sums += registers) {
    const std::ptrdiff_t offset = end.origin == nullptr ? 0 : out - end.origin;
    for (std::size_t v = 0; v * lanes < count && v < registers; ++v) {
      const std::size_t left = count - v * lanes;
      const std::size_t place = static_cast<std::size_t>(offset) + v * lanes;
      Register<T> value = sums[v];
      if (end.bias != nullptr) value += load(end.bias + first + v * lanes);
      if (end.adds) value += load_lanes<T>(out + v * lanes, left);
      if (end.gate != nullptr) {
        value = gated<T>(end.gate + place / 8, value, end.slope);
      } else {
        value = value > T(0) ? value : value * end.slope;
      }
      if (end.positive != nullptr) write_signs(value, end.positive + place / 8);
      if (end.addend != nullptr) value += load_lanes<T>(end.addend + place, left);
      store_lanes<T>(value, out + v * lanes, left);
    }
  }
}

/// Stores whole vectors of the common epilogues, chosen at compile time.
template <std::floating_point T, bool HasGate, bool HasSigns, bool HasAddend>
__attribute__((noinline)) void store_whole(const Epilogue<T>& end, const Register<T>* sums, std::size_t rows,
                                           std::size_t registers, std::size_t first, T* out,
                                           std::ptrdiff_t step) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  const std::ptrdiff_t offset = out - end.origin;
  const T slope = end.slope;
  const T* const bias = end.bias == nullptr ? nullptr : end.bias + first;
  const bool adds = end.adds;
  const std::uint8_t* gate = HasGate ? end.gate + offset / 8 : nullptr;
  std::uint8_t* signs = HasSigns ? end.positive + offset / 8 : nullptr;
  const T* addend = HasAddend ? end.addend + offset : nullptr;
  for (std::size_t row = 0; row < rows; ++row, sums += registers) {
    for (std::size_t v = 0; v < registers; ++v) {
      Register<T> value = sums[v];
      if (bias != nullptr) value += load(bias + v * lanes);
      if (adds) value += load(out + v * lanes);
      if constexpr (HasGate) {
        value = gated<T>(gate + v * lanes / 8, value, slope);
      } else {
        value = value > T(0) ? value : value * slope;
      }
      if constexpr (HasSigns) write_signs(value, signs + v * lanes / 8);
      if constexpr (HasAddend) value += load(addend + v * lanes);
      store(out + v * lanes, value);
    }
    out += step;
    if constexpr (HasGate) gate += step / 8;
    if constexpr (HasSigns) signs += step / 8;
    if constexpr (HasAddend) addend += step;
  }
}

#define TAPESTRY_FOR_EACH_SUM \
  _Pragma("GCC unroll 16") for (int p = 0; p < P; ++p) _Pragma("GCC unroll 2") for (int v = 0; v < V; ++v)

/// The slow path of store_tile().
template <std::floating_point T>
__attribute__((noinline)) void store_otherwise(const Epilogue<T>& end, const Register<T>* sums,
                                               std::size_t rows, std::size_t registers, std::size_t first,
                                               T* out, std::ptrdiff_t step, std::size_t count) {
  if (end.curve.kind != CurveKind::none)
    return store_curved<T>(end, sums, rows, registers, first, out, step, count);
  const bool is_whole = count >= registers * Vector<T>::lanes;
  if (is_whole && end.gate != nullptr && end.positive == nullptr && end.addend == nullptr)
    return store_whole<T, true, false, false>(end, sums, rows, registers, first, out, step);
  if (is_whole && end.gate == nullptr && end.positive != nullptr && end.addend == nullptr)
    return store_whole<T, false, true, false>(end, sums, rows, registers, first, out, step);
  if (is_whole && end.gate == nullptr && end.positive != nullptr)
    return store_whole<T, false, true, true>(end, sums, rows, registers, first, out, step);
  if (is_whole && end.gate == nullptr)
    return store_whole<T, false, false, true>(end, sums, rows, registers, first, out, step);
  store_any<T>(end, sums, rows, registers, first, out, step, count);
}

/// Applies the epilogue to sums of P outputs, `step` apart, and writes their `count` leading values, or all.
/// On the fast path the sums stay in registers, so this function must be inlined.
template <std::floating_point T, int P, int V>
__attribute__((always_inline)) inline void store_tile(const Epilogue<T>& end, Register<T> (&sum)[P][V],
                                                      std::size_t first, T* out, std::ptrdiff_t step,
                                                      std::size_t count) {
  constexpr std::ptrdiff_t lanes = Vector<T>::lanes;
  const bool is_short = (has_masks || count >= V * lanes) && end.gate == nullptr && end.positive == nullptr &&
                        end.addend == nullptr && end.curve.kind == CurveKind::none;
  if (!is_short) {
    Register<T> copy[P][V];
    TAPESTRY_FOR_EACH_SUM copy[p][v] = sum[p][v];
    return store_otherwise<T>(end, &copy[0][0], P, V, first, out, step, count);
  }
  if (end.bias != nullptr) TAPESTRY_FOR_EACH_SUM sum[p][v] += load(end.bias + first + v * lanes);
  if (has_masks && count < V * lanes) {
    const std::size_t left = count > static_cast<std::size_t>((V - 1) * lanes) ? count - (V - 1) * lanes : 0;
    const std::size_t counts[2] = {V == 1 ? left : count, left};
    if (end.adds) TAPESTRY_FOR_EACH_SUM sum[p][v] += load_lanes<T>(out + p * step + v * lanes, counts[v]);
    TAPESTRY_FOR_EACH_SUM sum[p][v] = sum[p][v] > T(0) ? sum[p][v] : sum[p][v] * end.slope;
    TAPESTRY_FOR_EACH_SUM store_lanes<T>(sum[p][v], out + p * step + v * lanes, counts[v]);
    return;
  }
  if (end.adds) TAPESTRY_FOR_EACH_SUM sum[p][v] += load(out + p * step + v * lanes);
  if (end.slope != T(1))
    TAPESTRY_FOR_EACH_SUM sum[p][v] = sum[p][v] > T(0) ? sum[p][v] : sum[p][v] * end.slope;
  TAPESTRY_FOR_EACH_SUM store(out + p * step + v * lanes, sum[p][v]);
}

#undef TAPESTRY_FOR_EACH_SUM

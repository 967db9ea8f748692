// Epilogues of sums before they are stored, for one instruction set. See Epilogue for the definition.
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

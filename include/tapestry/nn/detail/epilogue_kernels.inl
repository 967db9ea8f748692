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
      if (end.factor != nullptr) value *= load_lanes<T>(end.factor + place, left);
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

#define TAPESTRY_FOR_EACH_SUM \
  _Pragma("GCC unroll 16") for (int p = 0; p < P; ++p) _Pragma("GCC unroll 2") for (int v = 0; v < V; ++v)

/// Applies the factor, the slope or gate, the signs and the addend to whole vectors of sums, in registers.
template <std::floating_point T, int P, int V>
__attribute__((always_inline)) inline void finish_laid_out(const Epilogue<T>& end, Register<T> (&sum)[P][V],
                                                           const T* out, std::ptrdiff_t step) {
  constexpr std::ptrdiff_t lanes = Vector<T>::lanes;
  const std::ptrdiff_t offset = out - end.origin;
  const T slope = end.slope;  // copies, which stores cannot change
  std::uint8_t* const positive = end.positive;
  const T* const addend = end.addend;
  if (const T* const factor = end.factor; factor != nullptr)
    TAPESTRY_FOR_EACH_SUM sum[p][v] *= load(factor + (offset + p * step + v * lanes));
  if (const std::uint8_t* const gate = end.gate; gate != nullptr) {
    TAPESTRY_FOR_EACH_SUM sum[p][v] = gated<T>(gate + (offset + p * step + v * lanes) / 8, sum[p][v], slope);
  } else if (slope != T(1)) {
    TAPESTRY_FOR_EACH_SUM sum[p][v] = sum[p][v] > T(0) ? sum[p][v] : sum[p][v] * slope;
  }
  if (positive != nullptr)
    TAPESTRY_FOR_EACH_SUM write_signs(sum[p][v], positive + (offset + p * step + v * lanes) / 8);
  if (addend != nullptr) TAPESTRY_FOR_EACH_SUM sum[p][v] += load(addend + (offset + p * step + v * lanes));
}

/// Applies the epilogue to sums of P outputs, `step` apart, and writes their `count` leading values, or all.
/// But for curves and parts of vectors the sums stay in registers, so this function must be inlined.
template <std::floating_point T, int P, int V>
__attribute__((always_inline)) inline void store_tile(const Epilogue<T>& end, Register<T> (&sum)[P][V],
                                                      std::size_t first, T* out, std::ptrdiff_t step,
                                                      std::size_t count) {
  constexpr std::ptrdiff_t lanes = Vector<T>::lanes;
  const bool is_whole = count >= V * lanes, is_curved = end.curve.kind != CurveKind::none;
  const bool is_plain =
      end.factor == nullptr && end.gate == nullptr && end.positive == nullptr && end.addend == nullptr;
  if (is_curved || !(is_whole || (has_masks && is_plain))) {
    Register<T> copy[P][V];
    TAPESTRY_FOR_EACH_SUM copy[p][v] = sum[p][v];
    return (is_curved ? store_curved<T> : store_any<T>)(end, &copy[0][0], P, V, first, out, step, count);
  }
  if (end.bias != nullptr) TAPESTRY_FOR_EACH_SUM sum[p][v] += load(end.bias + first + v * lanes);
  if (!is_whole) {
    const std::size_t left = count > static_cast<std::size_t>((V - 1) * lanes) ? count - (V - 1) * lanes : 0;
    const std::size_t counts[2] = {V == 1 ? left : count, left};
    if (end.adds) TAPESTRY_FOR_EACH_SUM sum[p][v] += load_lanes<T>(out + p * step + v * lanes, counts[v]);
    TAPESTRY_FOR_EACH_SUM sum[p][v] = sum[p][v] > T(0) ? sum[p][v] : sum[p][v] * end.slope;
    TAPESTRY_FOR_EACH_SUM store_lanes<T>(sum[p][v], out + p * step + v * lanes, counts[v]);
    return;
  }
  if (end.adds) TAPESTRY_FOR_EACH_SUM sum[p][v] += load(out + p * step + v * lanes);
  if (!is_plain || end.slope != T(1)) finish_laid_out<T, P, V>(end, sum, out, step);
  TAPESTRY_FOR_EACH_SUM store(out + p * step + v * lanes, sum[p][v]);
}

#undef TAPESTRY_FOR_EACH_SUM

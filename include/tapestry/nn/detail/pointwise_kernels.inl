// Kernels over single values, windows and periods, for one instruction set.
#include <tapestry/nn/detail/depthwise_kernels.inl>

/// to[i] += from[i]
template <std::floating_point T>
void add(const T* from, T* to, std::size_t count) {
  std::size_t i = 0;
  for (; i + Vector<T>::lanes <= count; i += Vector<T>::lanes) store(to + i, load(to + i) + load(from + i));
  for (; i < count; ++i) to[i] += from[i];
}

/// to[i] *= from[i]
template <std::floating_point T>
void multiply(const T* from, T* to, std::size_t count) {
  std::size_t i = 0;
  for (; i + Vector<T>::lanes <= count; i += Vector<T>::lanes) store(to + i, load(to + i) * load(from + i));
  for (; i < count; ++i) to[i] *= from[i];
}

/// Bit i mod 8 of byte i / 8: whether value[i] is above 0.
template <std::floating_point T>
void positive_bits(const T* value, std::uint8_t* bits, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  std::size_t i = 0;
  if constexpr (lanes % 8 == 0)
    for (; i + lanes <= count; i += lanes) {
      const Register<T> x = load(value + i);
      write_signs(x, bits + i / 8);
    }
  for (; i < count; i += 8) {
    unsigned byte = 0;
    for (std::size_t j = 0; j < 8 && i + j < count; ++j) byte |= static_cast<unsigned>(value[i + j] > 0) << j;
    bits[i / 8] = static_cast<std::uint8_t>(byte);
  }
}

/// to[i] = from[i], times slope where bit i is not set
template <std::floating_point T>
void leaky_adjoint(const std::uint8_t* bits, T slope, const T* from, T* to, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  std::size_t i = 0;
  if constexpr (lanes % 8 == 0)
    for (; i + lanes <= count; i += lanes) {
      const Register<T> x = load(from + i);
      store(to + i, gated<T>(bits + i / 8, x, slope));
    }
  for (; i < count; ++i) to[i] = from[i] * ((bits[i / 8] >> i % 8 & 1) != 0 ? T(1) : slope);
}

/// out[i] = scale[i mod period] · in[i] + shift[i mod period]
template <std::floating_point T>
void affine(const T* in, const T* scale, const T* shift, std::size_t period, T* out, std::size_t count) {
  for (std::size_t begin = 0; begin < count; begin += period) {
    const std::size_t run = count - begin < period ? count - begin : period;
    std::size_t i = 0;
    for (; i + Vector<T>::lanes <= run; i += Vector<T>::lanes) {
      store(out + begin + i, load(scale + i) * load(in + begin + i) + load(shift + i));
    }
    for (; i < run; ++i) out[begin + i] = scale[i] * in[begin + i] + shift[i];
  }
}

/// adjoint[i] = a[i mod period] · adjoint[i] + b[i mod period] · value[i] + c[i mod period]
template <std::floating_point T>
void combine(const T* value, const T* a, const T* b, const T* c, std::size_t period, T* adjoint,
             std::size_t count) {
  for (std::size_t begin = 0; begin < count; begin += period) {
    const std::size_t run = count - begin < period ? count - begin : period;
    std::size_t i = 0;
    for (; i + Vector<T>::lanes <= run; i += Vector<T>::lanes)
      store(adjoint + begin + i,
            load(a + i) * load(adjoint + begin + i) + load(b + i) * load(value + begin + i) + load(c + i));
    for (; i < run; ++i) adjoint[begin + i] = a[i] * adjoint[begin + i] + b[i] * value[begin + i] + c[i];
  }
}

/// sums[i mod period] += x[i] and products[i mod period] += x[i] · (y[i] − origin[i mod period])
template <std::floating_point T>
void periodic_sums(const T* x, const T* y, const T* origin, std::size_t period, T* sums, T* products,
                   std::size_t count) {
  for (std::size_t begin = 0; begin < count; begin += period) {
    const std::size_t run = count - begin < period ? count - begin : period;
    std::size_t i = 0;
    for (; i + Vector<T>::lanes <= run; i += Vector<T>::lanes) {
      const Register<T> value = load(x + begin + i);
      store(sums + i, load(sums + i) + value);
      store(products + i, load(products + i) + value * (load(y + begin + i) - load(origin + i)));
    }
    for (; i < run; ++i) {
      sums[i] += x[begin + i];
      products[i] += x[begin + i] * (y[begin + i] - origin[i]);
    }
  }
}

/// a[0], b[0], a[1], b[1], … in two vectors.
template <std::floating_point T>
inline void interleave_lanes(const Register<T>& a, const Register<T>& b, Register<T>& low,
                             Register<T>& high) {
  constexpr int n = static_cast<int>(Vector<T>::lanes);
  if constexpr (n == 16) {
    low = __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    high = __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
  } else if constexpr (n == 8) {
    low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
    high = __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
  } else if constexpr (n == 4) {
    low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
    high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  } else {
    low = __builtin_shufflevector(a, b, 0, 2);
    high = __builtin_shufflevector(a, b, 1, 3);
  }
}

template <std::floating_point T, bool HasChoice>
inline void max_pool_window(const MaxPoolArguments<T>& a) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  using Choices = typename Vector<ElementIndex<T>>::Register;
  for (std::size_t channel = 0; channel < a.channels; channel += lanes) {
    Register<T> best = load(a.in + channel);
    Choices choice = Choices{} + a.first_position;
    for (std::size_t row = 0; row < a.rows; ++row) {
      const T* in = a.in + row * a.row_step + channel;
      for (std::size_t column = 0; column < a.columns; ++column, in += a.channels) {
        const Register<T> value = load(in);
        const auto is_better = HasChoice ? (value > best) | ((value != value) & (best == best))
                                         : (value > best) | (value != value);
        best = is_better ? value : best;
        if constexpr (HasChoice) {
          const auto position = a.first_position + static_cast<ElementIndex<T>>(row * a.width + column);
          choice = is_better ? Choices{} + position : choice;
        }
      }
    }
    const std::size_t count = a.channels - channel;
    store_lanes<T>(best, a.out + channel, count);
    if constexpr (HasChoice) store_lanes<ElementIndex<T>>(choice, a.choice + channel, count);
  }
}

/// The largest value of each channel in a window of pixels, and its place. Of equal values the first counts,
/// and NaN counts as the largest.
template <std::floating_point T>
void max_pool_pixel(const MaxPoolArguments<T>& a) {
  if (a.choice == nullptr) return max_pool_window<T, false>(a);
  max_pool_window<T, true>(a);
}

/// Elements begin … end − 1 of even[0], odd[0], even[1], odd[1], …, which are read by whole vectors.
template <std::floating_point T>
void interleave(const T* even, const T* odd, std::size_t begin, std::size_t end, T* out) {
  std::size_t i = begin;
  if (i % 2 != 0 && i < end) out[i - begin] = odd[i / 2], ++i;
  constexpr std::size_t lanes = Vector<T>::lanes;
  for (; i < end; i += 2 * lanes) {
    const std::size_t left = end - i;
    const Register<T> a = load(even + i / 2), b = load(odd + i / 2);
    Register<T> low, high;
    interleave_lanes<T>(a, b, low, high);
    store_lanes<T>(low, out + (i - begin), left);
    if (left > lanes) store_lanes<T>(high, out + (i - begin) + lanes, left - lanes);
  }
}

/// Lanes First, First + 2, … of two vectors.
template <std::floating_point T, int First, int... Lane>
inline Register<T> every_second(const Register<T>& a, const Register<T>& b,
                                std::integer_sequence<int, Lane...>) {
  return __builtin_shufflevector(a, b, (2 * Lane + First)...);
}

/// Adds such elements to even[0], odd[0], even[1], odd[1], …; null for those that are not wanted.
template <std::floating_point T>
void interleave_adjoint(const T* from, std::size_t begin, std::size_t end, T* even, T* odd) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  constexpr std::make_integer_sequence<int, static_cast<int>(lanes)> all{};
  std::size_t i = begin;
  if (i % 2 != 0 && i < end) {
    if (odd != nullptr) odd[i / 2] += from[i - begin];
    ++i;
  }
  for (; i + 2 * lanes <= end; i += 2 * lanes) {
    const Register<T> a = load(from + (i - begin)), b = load(from + (i - begin) + lanes);
    if (even != nullptr) store(even + i / 2, load(even + i / 2) + every_second<T, 0>(a, b, all));
    if (odd != nullptr) store(odd + i / 2, load(odd + i / 2) + every_second<T, 1>(a, b, all));
  }
  for (; i < end; ++i)
    if (T* const to = i % 2 == 0 ? even : odd; to != nullptr) to[i / 2] += from[i - begin];
}

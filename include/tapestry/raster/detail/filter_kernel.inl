// Filtered lookups in an atlas, for one instruction set.
#include <tapestry/raster/detail/draw_kernels.inl>

/// Square roots of numbers from 0 to 1e300, to a few units of the last place: 1/√x by Newton's iterations
/// from half the negative exponent.
inline Doubles root(const Doubles& value) {
  const Doubles at_least = value > 1e-300 ? value : Doubles{} + 1e-300;
  Doubles inverse = reinterpret_cast<Doubles>(0x5fe6eb50c7b537a9 - (reinterpret_cast<Longs>(at_least) >> 1));
  const Doubles half = at_least * 0.5;
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    const Doubles square = inverse * inverse, product = half * square;
    inverse = inverse * (1.5 - product);
  }
  return value * inverse;
}

/// The number rounded up, for numbers from 0 to 2³¹; numbers up to a billionth above an integer become that
/// integer.
inline Doubles rounded_up(const Doubles& wanted) {
  const Doubles value = wanted - 1e-9;
  const Doubles nearest = (value + rounding_magic) - rounding_magic;
  const Doubles zero = {};
  return nearest + (nearest < value ? zero + 1.0 : zero);
}

/// log₂ of numbers from 1, to 1e-11, and exact for powers of 2.
inline Doubles log_2(const Doubles& value) {
  const Longs bits = reinterpret_cast<Longs>(value);
  const Doubles one = Doubles{} + 1.0;
  const Longs mantissa = (bits & 0xFFFFFFFFFFFFF) | reinterpret_cast<Longs>(one);
  const Doubles m = reinterpret_cast<Doubles>(mantissa);
  const Doubles exponent = reinterpret_cast<Doubles>((bits >> 52) | 0x4330000000000000) - (0x1p52 + 1023);
  // ln m = 2 artanh s = 2 s · (1 + s²/3 + s⁴/5 + …), s = (m − 1) / (m + 1) ≤ 1/3.
  const Doubles s = (m - one) / (m + one);
  const Doubles z = s * s;
  constexpr double terms[] = {1.0 / 19, 1.0 / 17, 1.0 / 15, 1.0 / 13, 1.0 / 11,
                              1.0 / 9,  1.0 / 7,  1.0 / 5,  1.0 / 3,  1.0};
  Doubles sum = (one - one) + 1.0 / 21;
#pragma GCC unroll 10
  for (const double term : terms) {
    const Doubles product = sum * z;
    sum = product + term;
  }
  const Doubles natural = s * sum;
  const Doubles scaled = natural * 2.8853900817779268;  // 2 / ln 2
  return exponent + scaled;
}

/// Chooses level and places of fragments, see AtlasFilter. Works on whole vectors of the arrays.
inline void choose_lookups(const LookupRule& rule, LookupBatch& batch, std::size_t count) {
  const Doubles zero = {}, one = zero + 1.0;
  for (std::size_t i = 0; i < count; i += VertexBlock::wide) {
    const Doubles a = load(batch.steps[0].data() + i), b = load(batch.steps[1].data() + i);
    const Doubles c = load(batch.steps[2].data() + i), d = load(batch.steps[3].data() + i);
    // J Jᵀ = [p r; r q]: half the sum of its eigenvalues and half their difference.
    const Doubles aa = a * a, bb = b * b, cc = c * c, dd = d * d, ab = a * b, cd = c * d, ad = a * d,
                  cb = c * b;
    const Doubles p = aa + cc, q = bb + dd, r = ab + cd, area = ad - cb;
    const Doubles half = (p - q) * 0.5, half_sum = (p + q) * 0.5, half_square = half * half, r_square = r * r;
    const Doubles spread = root(half_square + r_square);
    const Doubles long_square = half_sum + spread;
    const Doubles area_square = area * area;
    const Doubles quotient = area_square / long_square;
    const Doubles wide_square = quotient > one ? quotient : one;  // no less than a texel
    const Doubles ratio_square = long_square / wide_square;
    const Doubles is_bounded = ratio_square < 4096.0 ? ratio_square : zero + 4096.0;
    Doubles lookups = rounded_up(root(is_bounded > one ? is_bounded : one));
    lookups = lookups > rule.most_lookups ? zero + rule.most_lookups : lookups;
    const Doubles each = one / lookups;
    const Doubles each_square = each * each, apart_square = long_square * each_square;
    Doubles size_square = wide_square > apart_square ? wide_square : apart_square;
    size_square = size_square < 1e30 ? size_square : zero + 1e30;
    const Doubles level = log_2(size_square) * 0.5;
    store(batch.level.data() + i, level < rule.top_level ? level : zero + rule.top_level);
    store(batch.lookups.data() + i, lookups);
    // The eigenvector of the greater, by the row of J Jᵀ − (half_sum − spread) that does not cancel.
    const Doubles greater = spread + (half < 0 ? -half : half);
    const Doubles x = half < 0 ? r : greater, y = half < 0 ? greater : r;
    const Doubles greater_square = greater * greater, norm_square = greater_square + r_square;
    const Doubles stretch_square = long_square / norm_square;
    const Doubles stretch = root(stretch_square > 0 ? stretch_square : zero) * each;
    const Longs is_row = (lookups > one) & (long_square < 1e30);
    const Doubles column = x * stretch, row = y * stretch;
    const Doubles column_step = column / rule.atlas_size[0], row_step = row / rule.atlas_size[1];
    store(batch.between[0].data() + i, is_row ? column_step : zero);
    store(batch.between[1].data() + i, is_row ? row_step : zero);
  }
}

/// Places along an axis of the lookups of one fragment a lane, in one level.
struct LaneAxis {
  alignas(64) std::int32_t whole[lanes];  // texels from the first one's centre to the first place,
  alignas(64) float rest[lanes];          // rounded down so far that all rests are positive
  alignas(64) float between[lanes];       // two lookups
  alignas(64) std::int32_t last[lanes];   // texel

  inline void set(std::size_t lane, double place, double step, double lookups, std::size_t size) {
    const double texels = static_cast<double>(size), between_texels = step * texels;
    const double at = place * texels, centre = at - 0.5, reach = (lookups - 1) * 0.5 * between_texels;
    const double first = centre - reach, end = centre + reach;
    whole[lane] = static_cast<std::int32_t>(first < end ? first : end) - 1;
    rest[lane] = static_cast<float>(first - whole[lane]);
    between[lane] = static_cast<float>(between_texels);
    last[lane] = static_cast<std::int32_t>(size) - 1;
  }
};

/// Taps of each lane along an axis: the texel before its place, −1 if another follows, and that one's weight.
struct LaneTaps {
  Ints first, has_second;
  Floats share;
};

inline void take_taps(const LaneAxis& axis, float lookup, LaneTaps& taps) {
  const Floats along = load(axis.between) * lookup;
  const Floats position = along + load(axis.rest);
  const Ints below = __builtin_convertvector(position, Ints);
  const Floats share = position - __builtin_convertvector(below, Floats);
  const Ints texel = below + load(axis.whole), last = load(axis.last);
  const Ints zero = {};
  taps.has_second = (texel >= 0) & (texel < last) & (share > 0);
  const Ints not_below = texel < 0 ? zero : texel;
  taps.first = not_below > last ? last : not_below;
  taps.share = reinterpret_cast<Floats>(reinterpret_cast<Ints>(share) & taps.has_second);
}

/// Two neighbouring texels, and two unused numbers.
typedef float TexelPair __attribute__((vector_size(32)));
typedef float TexelPairInMemory __attribute__((vector_size(32), aligned(4), may_alias));

/// Lookups of one fragment a lane, in one level each.
struct LaneLookups {
  LaneAxis across, down;
  alignas(64) float weight[lanes];  // of one lookup
  alignas(64) std::int32_t first_texel[lanes];
  std::size_t lookups[lanes];
  std::size_t most = 0;

  inline void set(std::size_t lane, const MipLevel& level, const LookupBatch& batch, std::size_t fragment,
                  double share) {
    const double count = batch.lookups[fragment];
    across.set(lane, batch.place[0][fragment], batch.between[0][fragment], count, level.width);
    down.set(lane, batch.place[1][fragment], batch.between[1][fragment], count, level.height);
    weight[lane] = static_cast<float>(share / count);
    first_texel[lane] = static_cast<std::int32_t>(level.first_texel);
    lookups[lane] = static_cast<std::size_t>(count);
    most = most < lookups[lane] ? lookups[lane] : most;
  }
};

/// Place of each lane's lookup: a pair of texels in an upper and a lower row.
struct LanePairs {
  alignas(64) std::int32_t upper[lanes], lower[lanes];
  alignas(64) float upper_weight[lanes], lower_weight[lanes];
  alignas(64) float right_share[lanes];
};

/// Adds a lane's lookups to its sum.
inline void add_pairs(const float* texels, const LanePairs* pairs, std::size_t lookups, std::size_t lane,
                      float* sum) {
  TexelPair whole = {}, moved = {};
  for (std::size_t i = 0; i < lookups; ++i) {
    const TexelPair upper = *reinterpret_cast<const TexelPairInMemory*>(texels + pairs[i].upper[lane]);
    const TexelPair lower = *reinterpret_cast<const TexelPairInMemory*>(texels + pairs[i].lower[lane]);
    const TexelPair upper_part = upper * pairs[i].upper_weight[lane];
    const TexelPair lower_part = lower * pairs[i].lower_weight[lane];
    const TexelPair column = upper_part + lower_part;
    const TexelPair share = column * pairs[i].right_share[lane];
    whole += column;
    moved += share;
  }
  const TexelPair left = {1, 1, 1, 0, 0, 0, 0, 0}, to_right = {-1, -1, -1, 1, 1, 1, 0, 0};
  const TexelPair at_left = whole * left, change = moved * to_right;
  const TexelPair part = at_left + change;
  *reinterpret_cast<TexelPairInMemory*>(sum) += part;
}

inline void take_pairs(const LaneLookups& block, std::size_t lookup, LanePairs& pairs) {
  LaneTaps across, down;
  take_taps(block.across, static_cast<float>(lookup), across);
  take_taps(block.down, static_cast<float>(lookup), down);
  const Floats each = load(block.weight), lower = each * down.share;
  store(pairs.upper_weight, each - lower);
  store(pairs.lower_weight, lower);
  store(pairs.right_share, across.share);
  const Ints columns = load(block.across.last) + 1;
  const Ints upper = down.first * columns + load(block.first_texel) + across.first;
  store(pairs.upper, upper * 3);
  store(pairs.lower, (upper + (columns & down.has_second)) * 3);
}

inline void add_lookups(const float* texels, const LaneLookups& block, std::size_t count, float* sums) {
  constexpr std::size_t most_pairs = 8;
  LanePairs pairs[most_pairs];
  for (std::size_t begin = 0; begin < block.most; begin += most_pairs) {
    const std::size_t end = block.most - begin < most_pairs ? block.most : begin + most_pairs;
    for (std::size_t lookup = begin; lookup < end; ++lookup) take_pairs(block, lookup, pairs[lookup - begin]);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const std::size_t last = block.lookups[lane] < end ? block.lookups[lane] : end;
      if (begin < last) add_pairs(texels, pairs, last - begin, lane, sums + 8 * lane);
    }
  }
}

/// Sums of fragments, [count, 8]: the sums of left texels' {red, green, blue}, then of right ones', and two
/// unused numbers; 0 for fragments without lookups. Texels beside a lookup are read with a weight of 0.
/// \pre lookups keep off the two highest levels, and 3 times the number of texels is below 2³¹
inline void look_up(const PyramidTexels& pyramid, const LookupBatch& batch, std::size_t count, float* sums) {
  for (std::size_t i = 0; i < 8 * count; ++i) sums[i] = 0;
  LaneLookups block = {};
  for (std::size_t begin = 0; begin < count; begin += lanes) {
    const std::size_t size = count - begin < lanes ? count - begin : lanes;
    for (std::size_t coarser = 0; coarser < 2; ++coarser) {
      block.most = 0;
      for (std::size_t lane = 0; lane < size; ++lane) {
        const std::size_t fragment = begin + lane, finer = static_cast<std::size_t>(batch.level[fragment]);
        const double share = batch.level[fragment] - static_cast<double>(finer);
        block.lookups[lane] = 0;
        if (batch.lookups[fragment] > 0 && (coarser == 0 || share > 0))
          block.set(lane, pyramid.levels[finer + coarser], batch, fragment, coarser == 0 ? 1 - share : share);
      }
      add_lookups(pyramid.texels, block, size, sums + 8 * begin);
    }
  }
}

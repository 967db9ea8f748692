// Samples into fragments, for one instruction set.
#include <tapestry/raster/detail/filter_kernel.inl>

/// The samples of a pixel, row by row, and for each one 1 | row << 10 | column << 20.
template <std::size_t Axis>
struct PixelSamples {
  static constexpr std::size_t parts = Axis * Axis / 4;
  FourInts face[parts];
  FourInts place[parts];
};

template <std::size_t Axis>
inline void set_places(PixelSamples<Axis>& pixel) {
  for (std::size_t s = 0; s < Axis * Axis; ++s)
    pixel.place[s / 4][s % 4] = static_cast<std::int32_t>(1 | (s / Axis) << 10U | (s % Axis) << 20U);
}

/// Reads a pixel; returns whether all its samples are alike.
template <std::size_t Axis>
inline bool read_samples(const std::int32_t* corner, std::size_t stride, PixelSamples<Axis>& pixel) {
  if constexpr (Axis == 2) {
    pixel.face[0] = FourInts{corner[0], corner[1], corner[stride], corner[stride + 1]};
  } else {
    constexpr std::size_t each = Axis / 4;  // parts of a row
    for (std::size_t part = 0; part < PixelSamples<Axis>::parts; ++part)
      pixel.face[part] =
          *reinterpret_cast<const FourIntsInMemory*>(corner + part / each * stride + part % each * 4);
  }
  const FourInts first = FourInts{} + corner[0];
  FourInts difference = {};
  for (const FourInts& part : pixel.face) difference |= part ^ first;
  return (difference[0] | difference[1] | difference[2] | difference[3]) == 0;
}

/// Writes a fragment for each face of a pixel, in the order of their first samples; returns their number.
template <std::size_t Axis>
inline std::size_t write_faces(PixelSamples<Axis>& pixel, std::size_t row, std::size_t column,
                               const FragmentColumns& out, std::size_t size) {
  constexpr float share = 1 / static_cast<float>(Axis * Axis);
  const std::size_t before = size;
  for (std::size_t s = 0; s < Axis * Axis; ++s) {
    const std::int32_t own = pixel.face[s / 4][s % 4];
    if (own < 0) continue;  // none, or written before
    FourInts sums = {};
    for (std::size_t part = s / 4; part < PixelSamples<Axis>::parts; ++part) {
      const FourInts is_own = pixel.face[part] == own;
      sums += is_own & pixel.place[part];
      pixel.face[part] |= is_own;
    }
    const std::int32_t sum = sums[0] + sums[1] + sums[2] + sums[3];
    const std::int32_t count = sum & 0x3FF, down = (sum >> 10) & 0x3FF, right = sum >> 20;
    const double each = 1 / static_cast<double>(count);
    const double along = each * static_cast<double>(right), below = each * static_cast<double>(down);
    out.column[size] = static_cast<std::uint32_t>(column);
    out.face[size] = own;
    out.coverage[size] = share * static_cast<float>(count);
    out.sample_column[size] = static_cast<double>(column * Axis) + along;
    out.sample_row[size] = static_cast<double>(row * Axis) + below;
    ++size;
  }
  return size - before;
}

template <std::size_t Axis>
inline std::size_t scan_pixels_of(const SampleRows& samples, std::size_t row, std::size_t begin,
                                  std::size_t end, const FragmentColumns& out) {
  constexpr double centre = 0.5 * static_cast<double>(Axis - 1);
  PixelSamples<Axis> pixel;
  set_places(pixel);
  std::size_t size = 0;
  for (std::size_t column = begin; column < end; ++column) {
    const std::int32_t* const corner = samples.faces + column * Axis;
    if (!read_samples(corner, samples.stride, pixel)) {
      size += write_faces(pixel, row, column, out, size);
      continue;
    }
    out.column[size] = static_cast<std::uint32_t>(column);
    out.face[size] = corner[0];
    out.coverage[size] = 1;
    out.sample_column[size] = static_cast<double>(column * Axis) + centre;
    out.sample_row[size] = static_cast<double>(row * Axis) + centre;
    size += corner[0] >= 0 ? 1 : 0;
  }
  return size;
}

/// Writes the fragments of columns begin … end − 1 of a pixel row, one for each face in each pixel; returns
/// their number. Writes one element beyond the last.
inline std::size_t scan_pixels(const SampleRows& samples, std::size_t row, std::size_t begin, std::size_t end,
                               const FragmentColumns& out) {
  if (samples.axis == 2) return scan_pixels_of<2>(samples, row, begin, end, out);
  if (samples.axis == 4) return scan_pixels_of<4>(samples, row, begin, end, out);
  return scan_pixels_of<8>(samples, row, begin, end, out);
}

#pragma once
#include <tapestry/raster/detail/operator_band.hpp>

namespace tapestry::raster {
/// The linear map from texture to picture of one view, sparse:
///
///   render[p, c] = constant[p, c] + light_colour[c] · Σ_i weights[i] · texels[texels_of[i], c]
///
/// over row_begin[r] ≤ i < row_begin[r + 1] for the row r with pixels[r] = p. Coverage and the face's
/// light are in the weights. Made by texture_operator(), applied by render() and render_adjoint().
/// Memory: see memory_bytes(); about 4 + sizeof(T) bytes an entry, and 4 to 9 entries a covered pixel, more
/// where an atlas is filtered.
template <std::floating_point T>
struct TextureOperator {
  std::size_t height = 0;
  std::size_t width = 0;
  std::size_t texel_count = 0;
  std::array<T, 3> light_colour{1, 1, 1};
  std::vector<std::uint32_t> pixels;     ///< row · width + column of pixels that show paint, ascending
  std::vector<std::uint32_t> row_begin;  ///< one more than pixels
  std::vector<std::uint32_t> texels_of;
  std::vector<T> weights;
  Array<T, 3> constant;  ///< [H, W, 3] lit colour of faces that are not painted, and what a ClearCoat
                         ///< mirrors, times coverage; of a CompactOperator empty
  std::vector<std::uint32_t> constant_pixels{};  ///< of a CompactOperator: where the constant is not 0
  std::vector<T> constants{};                    ///< of these pixels, three each
  Array<T, 2> coverage;                          ///< [H, W] share of the pixel that shows any face, in [0, 1]
  std::size_t non_finite_faces = 0;              ///< faces left out since a corner is not finite
};

/// Memory that an operator holds.
template <std::floating_point T>
[[nodiscard]] std::size_t memory_bytes(const TextureOperator<T>& picture) {
  return sizeof(std::uint32_t) * (picture.pixels.capacity() + picture.row_begin.capacity() +
                                  picture.texels_of.capacity() + picture.constant_pixels.capacity()) +
         sizeof(T) * (picture.weights.capacity() + picture.constants.capacity() + picture.constant.size() +
                      picture.coverage.size());
}

namespace detail {
template <std::floating_point T>
void join_bands(std::vector<OperatorBand<T>>& bands, TextureOperator<T>& picture) {
  std::size_t rows = 0, entries = 0;
  for (const auto& band : bands) {
    rows += band.pixels.size();
    entries += band.texels_of.size();
  }
  if (entries > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorKind::limit, "texture_operator: the view has more than 4294967295 entries");
  picture.pixels.reserve(rows);
  picture.row_begin.reserve(rows + 1);
  picture.texels_of.reserve(entries);
  picture.weights.reserve(entries);
  picture.row_begin.push_back(0);
  for (auto& band : bands) {
    picture.pixels.insert(picture.pixels.end(), band.pixels.begin(), band.pixels.end());
    picture.texels_of.insert(picture.texels_of.end(), band.texels_of.begin(), band.texels_of.end());
    picture.weights.insert(picture.weights.end(), band.weights.begin(), band.weights.end());
    for (const std::uint32_t count : band.entry_counts) {
      picture.row_begin.push_back(picture.row_begin.back() + count);
    }
    band = {};
  }
}

template <std::floating_point T, class Lighting>
void shade_band(const FragmentBands& fragments, std::size_t index, const FragmentShader<Lighting>& shader,
                OperatorBand<T>& band, TextureOperator<T>& picture) {
  PaintedFragments painted(shader, band);
  fragments.visit_band(index, grain_of(shader.body.layout), [&](const Fragment& fragment) {
    const auto face = static_cast<std::size_t>(fragment.face);
    picture.coverage.data()[fragment.pixel] += static_cast<T>(fragment.coverage);
    if (const float* const shown = shader.photographed(fragment)) {
      for (std::size_t c = 0; c < 3; ++c)
        picture.constant.data()[3 * fragment.pixel + c] +=
            static_cast<T>(fragment.coverage * static_cast<double>(shown[c]));
      return;
    }
    if constexpr (ReflectingLighting<Lighting>) {
      const auto reflected = shader.lighting.reflected(face, fragment.barycentric);
      for (std::size_t c = 0; c < 3; ++c)
        picture.constant.data()[3 * fragment.pixel + c] += static_cast<T>(fragment.coverage * reflected[c]);
    }
    if (shader.body.painted[face] != 0) {
      painted.add(fragment);
      return;
    }
    const std::array<double, 3> colour = shader.own_colour(fragment);
    const double light = shader.light_of(fragment);
    for (std::size_t c = 0; c < 3; ++c) {
      const double lit = colour[c] * light * shader.lighting.light_colour[c];
      picture.constant.data()[3 * fragment.pixel + c] += static_cast<T>(fragment.coverage * lit);
    }
  });
  painted.finish();
}

/// Prefetches the texel of an entry: textures are larger than caches, and their rows far apart.
template <std::floating_point T>
[[gnu::always_inline]] inline void prefetch_ahead(const TextureOperator<T>& picture, std::size_t entry,
                                                  const T* texels) {
  constexpr std::size_t distance = 48;
  const std::size_t ahead = std::min(entry + distance, picture.texels_of.size() - 1);
  __builtin_prefetch(texels + 3 * std::size_t{picture.texels_of[ahead]});
}

inline constexpr std::size_t most_parts = 64;

/// Adds the entries of those texels that belong to one of several parts, in the stored order.
template <bool IsShared, std::floating_point T>
void scatter(const TextureOperator<T>& picture, const T* render_adjoint, std::size_t part, std::size_t parts,
             T* texels_adjoint) {
  std::array<std::uint8_t, most_parts> is_own{};  // runs of 256 texels are dealt out in turn
  for (std::size_t i = part; i < is_own.size(); i += parts) is_own[i] = 1;
  const std::array<T, 3> light = picture.light_colour;
  const T* const weights = picture.weights.data();
  const std::uint32_t* const texels_of = picture.texels_of.data();
  const std::uint32_t* const row_begin = picture.row_begin.data();
  for (std::size_t row = 0; row < picture.pixels.size(); ++row) {
    const T* const pixel = render_adjoint + 3 * std::size_t{picture.pixels[row]};
    const T red = light[0] * pixel[0], green = light[1] * pixel[1], blue = light[2] * pixel[2];
    for (std::size_t i = row_begin[row], end = row_begin[row + 1]; i < end; ++i) {
      prefetch_ahead(picture, i, texels_adjoint);
      const std::uint32_t texel = texels_of[i];
      if (IsShared && is_own[(texel >> 8U) % is_own.size()] == 0) continue;
      T* const colour = texels_adjoint + 3 * std::size_t{texel};
      colour[0] += weights[i] * red;
      colour[1] += weights[i] * green;
      colour[2] += weights[i] * blue;
    }
  }
}
}  // namespace detail

/// Rasterises a view and keeps the linear map from texture to picture.
///
/// Cubes are looked up at every sample, as in Neural Mesh Renderer. Other textures are looked up once for
/// each face in each pixel: at the mean of the samples' barycentric coordinates, weighted by the number of
/// samples. The operator of a filtered atlas takes the texels of its pyramid, see stored_texels(). The result
/// is the same for any number of threads.
///
/// \param light             Unlit, Light (flat), SmoothLight or OutdoorLight, one with a ClearCoat, or a
///                          PhotographedLight
/// \param samples_per_axis  1, 2, 4 or 8: a pixel's coverage is estimated from its square
/// \throws ShapeError if body.painted does not have one entry a face
/// \throws DomainError for a picture, camera, light or layout outside the stated limits
/// \throws Error (mismatch) if a painted face has no uv, or a face refers to a missing position
template <std::floating_point T, LightModel Model = Light>
[[nodiscard, gnu::noinline]] TextureOperator<T> texture_operator(const PaintedMesh& body,
                                                                 const geometry::Camera& camera,
                                                                 std::size_t height, std::size_t width,
                                                                 const Model& light,
                                                                 std::size_t samples_per_axis = 2) {
  detail::require_layout("texture_operator", body);
  const FragmentBands fragments("texture_operator", body.mesh, camera, height, width, samples_per_axis);
  const auto lighting = prepare(body.mesh, camera, light);
  const auto shader = detail::make_shader(body, lighting, fragments, camera, height, width);

  TextureOperator<T> picture;
  picture.height = height;
  picture.width = width;
  picture.texel_count = stored_texel_count(body.layout, body.mesh);
  for (std::size_t c = 0; c < 3; ++c) picture.light_colour[c] = static_cast<T>(lighting.light_colour[c]);
  picture.constant = zeros<T, 3>({height, width, 3});
  picture.coverage = zeros<T, 2>({height, width});
  picture.non_finite_faces = fragments.non_finite_faces();
  std::vector<detail::OperatorBand<T>> bands(fragments.band_count());
  parallel_for(bands.size(), [&](std::size_t index) {
    bands[index].reserve(fragments.band_rows() * width);
    detail::shade_band(fragments, index, shader, bands[index], picture);
  });
  detail::join_bands(bands, picture);
  return picture;
}

// With other lights, such as a user's, it is compiled where it is used.
/// \cond
extern template decltype(texture_operator<float, Light>) texture_operator<float, Light>;
extern template decltype(texture_operator<double, Light>) texture_operator<double, Light>;
extern template decltype(texture_operator<float, Unlit>) texture_operator<float, Unlit>;
extern template decltype(texture_operator<double, Unlit>) texture_operator<double, Unlit>;
/// \endcond

/// The picture of a texture.
///
/// \param texels  [texel_count, 3]
/// \returns       [H, W, 3], colour times coverage, row 0 on top
/// \throws ShapeError if texels does not fit the operator
template <std::floating_point T>
[[nodiscard]] Array<T, 3> render(const TextureOperator<T>& picture, const Array<T, 2>& texels);

/// Adds Aᵀ·render_adjoint to texels_adjoint, A being the linear part of render().
///
/// Texels are divided among the threads in runs of 256; each thread reads all entries. The entries of a texel
/// are added in the stored order, so the sums are the same for any number of threads.
///
/// \param render_adjoint  [H, W, 3]
/// \param texels_adjoint  [texel_count, 3]
/// \throws ShapeError if an argument does not fit the operator
template <std::floating_point T>
void render_adjoint(const TextureOperator<T>& picture, const Array<T, 3>& render_adjoint,
                    Array<T, 2>& texels_adjoint);

/// The picture of a texture on the active tape; its pullback is render_adjoint(). A passive texture records
/// nothing.
///
/// \param picture  must outlive the tape's last reverse(), unchanged
/// \param texels   [texel_count, 3]
/// \returns        [H, W, 3], colour times coverage, row 0 on top
/// \throws ShapeError if texels does not fit the operator
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> render(const TextureOperator<T>& picture,
                                         const ArrayVariable<T, 2>& texels);

template <std::floating_point T>
void render(const TextureOperator<T>&&, const ArrayVariable<T, 2>&) = delete;  // it would be gone
/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] ArrayVariable<D, 3> render(const TextureOperator<typename D::value_type>& picture,
                                         const ArrayVariable<D, 2>& texels) {
  return record_affine([&picture](const auto& at) { return render(picture, at); }, texels);
}

/// An operator over those texels alone that it reads: texel_count is their number. A step with it costs the
/// same whatever the texture's size.
template <std::floating_point T>
struct CompactOperator : TextureOperator<T> {
  std::size_t whole_count = 0;        ///< texels of the texture
  std::vector<std::uint32_t> texels;  ///< number in the texture of each own texel, ascending
};

/// Memory that an operator holds.
template <std::floating_point T>
[[nodiscard]] std::size_t memory_bytes(const CompactOperator<T>& picture) {
  return memory_bytes(static_cast<const TextureOperator<T>&>(picture)) +
         picture.texels.capacity() * sizeof(std::uint32_t);
}

/// The operator over its own texels.
template <std::floating_point T>
[[nodiscard]] CompactOperator<T> compacted(TextureOperator<T> picture);

/// Rows of a texture that an operator reads, [texel_count, 3].
/// \param texels  [whole_count, 3]
/// \throws ShapeError if texels does not fit the operator
template <std::floating_point T>
[[nodiscard]] Array<T, 2> own_texels(const CompactOperator<T>& picture, const Array<T, 2>& texels) {
  require_shape("own_texels", "texels", texels, {picture.whole_count, 3});
  Array<T, 2> own(Extents<2>{picture.texels.size(), 3});
  for (std::size_t i = 0; i < picture.texels.size(); ++i)
    std::copy_n(texels.data() + 3 * std::size_t{picture.texels[i]}, 3, own.data() + 3 * i);
  return own;
}

/// Adds rows by an operator's own texels, each divided by `divisor`, to those of the texture.
/// \param own    [texel_count, 3]
/// \param texels [whole_count, 3]
template <std::floating_point T>
void add_own_texels(const CompactOperator<T>& picture, const Array<T, 2>& own, T divisor,
                    Array<T, 2>& texels) {
  parallel_for_blocks(picture.texels.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        texels.data()[3 * std::size_t{picture.texels[i]} + c] += own.data()[3 * i + c] / divisor;
  });
}

/// The pictures of a texture in several views, as one record on the active tape. Views are rendered and
/// pulled back side by side; their adjoints are summed in the order of views, so the result has the same bits
/// for any number of threads.
///
/// \param pictures  the views, which may differ in size; the tape keeps them alive
/// \param texels    [whole_count, 3]
/// \returns         of each view [H, W, 3], colour times coverage
/// \throws ShapeError if texels does not fit one of the operators
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 3>> render(
    const std::vector<std::shared_ptr<const CompactOperator<T>>>& pictures,
    const ArrayVariable<T, 2>& texels);

/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] std::vector<ArrayVariable<D, 3>> render(
    const std::vector<std::shared_ptr<const CompactOperator<typename D::value_type>>>& pictures,
    const ArrayVariable<D, 2>& texels) {
  return record_affine([pictures](const auto& at) { return render(pictures, at); }, texels);
}
}  // namespace tapestry::raster

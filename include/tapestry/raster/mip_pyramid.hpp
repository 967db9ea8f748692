#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/detail/mip_levels.hpp>

namespace tapestry::raster {
namespace detail {

/// The texels of the finer picture that one texel of the coarser covers along an axis: at most three, with
/// weights that sum to 1.
struct MipOverlap {
  std::size_t first;
  std::size_t count;
  std::array<double, 3> weights;
};

[[nodiscard]] std::vector<MipOverlap> mip_overlaps(std::size_t coarse_size, std::size_t fine_size);

/// A step between a level and the next coarser one.
struct MipStep {
  MipLevel fine;
  MipLevel coarse;
  std::vector<MipOverlap> rows;
  std::vector<MipOverlap> columns;

  MipStep(const MipLevel& finer, const MipLevel& coarser)
      : fine(finer),
        coarse(coarser),
        rows(mip_overlaps(coarser.height, finer.height)),
        columns(mip_overlaps(coarser.width, finer.width)) {}

  /// Calls visit(coarse texel, fine texel, weight) for the coarse texels of a row.
  template <class Visit>
  void visit_row(std::size_t i, Visit visit) const {
    for (std::size_t j = 0; j < coarse.width; ++j)
      for (std::size_t y = 0; y < rows[i].count; ++y)
        for (std::size_t x = 0; x < columns[j].count; ++x)
          visit(coarse.first_texel + i * coarse.width + j,
                fine.first_texel + (rows[i].first + y) * fine.width + columns[j].first + x,
                rows[i].weights[y] * columns[j].weights[x]);
  }

  /// Calls visit(coarse texel, fine texel) for the fine texels whose corner lies in a coarse row: each once.
  template <class Visit>
  void visit_children(std::size_t i, Visit visit) const {
    const auto first_row = [&](std::size_t row) {
      return (row * fine.height + coarse.height - 1) / coarse.height;
    };
    for (std::size_t y = first_row(i); y < first_row(i + 1); ++y)
      for (std::size_t x = 0; x < fine.width; ++x)
        visit(coarse.first_texel + i * coarse.width + x * coarse.width / fine.width,
              fine.first_texel + y * fine.width + x);
  }

  /// Calls visit(row) for all coarse rows, on all threads if `is_parallel`.
  template <class Visit>
  void for_each_row(bool is_parallel, Visit visit) const {
    const std::size_t block = is_parallel ? std::max<std::size_t>(1, 512 / coarse.width) : coarse.height;
    parallel_for_blocks(coarse.height, block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) visit(i);
    });
  }

  /// Whether no fine row lies in two coarse ones.
  [[nodiscard]] bool rows_are_apart() const { return fine.height % coarse.height == 0; }
};

}  // namespace detail

/// An atlas with all coarser pictures of it, as a linear map of its texels.
///
/// A texel of a level is the mean of the finer level over its own area, exactly so for odd sizes too. If it
/// is known which texels faces refer to, the mean is over those only. A texel without such parts takes the
/// colour of the next coarser level, also in the atlas itself, so that lookups at a chart's border find only
/// colours of the paint ("push-pull"). Source: Gortler et al., The Lumigraph (SIGGRAPH 1996), section 3.4.
class MipPyramid {
 public:
  /// The pyramid of an atlas whose texels all count.
  explicit MipPyramid(const TextureLayout& layout);

  /// \param used  [height, width], 0 where no face refers to a texel, see used_texels()
  /// \throws ShapeError if it does not fit the layout
  template <std::floating_point T>
  MipPyramid(const TextureLayout& layout, const Array<T, 2>& used) : MipPyramid(layout) {
    require_shape("MipPyramid", "used", used, {layout.height, layout.width});
    shares_.assign(texel_count_, 0.0);
    for (std::size_t i = 0; i < used.size(); ++i) shares_[i] = used.data()[i] != T(0) ? 1.0 : 0.0;
    for (const detail::MipStep& step : steps_)
      for (std::size_t i = 0; i < step.coarse.height; ++i)
        step.visit_row(i, [&](std::size_t coarse, std::size_t fine, double weight) {
          shares_[coarse] += weight * shares_[fine];
        });
  }

  /// Texels of all levels.
  [[nodiscard]] std::size_t texel_count() const { return texel_count_; }

  /// \param texels  [height · width, 3]
  /// \returns       [texel_count, 3], for operators of a filtered layout
  /// \throws ShapeError if texels does not fit the layout
  template <std::floating_point T>
  [[nodiscard]] Array<T, 2> operator()(const Array<T, 2>& texels) const {
    require_shape("MipPyramid", "texels", texels, {layout_.height * layout_.width, 3});
    auto pyramid = zeros<T, 2>({texel_count_, 3});
    T* const colours = pyramid.data();
    std::copy_n(texels.data(), texels.size(), colours);
    for (const detail::MipStep& step : steps_)
      step.for_each_row(true, [&](std::size_t i) {
        step.visit_row(i, [&](std::size_t coarse, std::size_t fine, double weight) {
          const double part = part_of(fine, coarse);
          if (part > 0) add(static_cast<T>(weight * part), colours + 3 * fine, colours + 3 * coarse);
        });
      });
    if (shares_.empty()) return pyramid;
    for (auto step = steps_.rbegin(); step != steps_.rend(); ++step)
      step->for_each_row(true, [&](std::size_t i) {
        step->visit_children(i, [&](std::size_t coarse, std::size_t fine) {
          if (shares_[fine] == 0) std::copy_n(colours + 3 * coarse, 3, colours + 3 * fine);
        });
      });
    return pyramid;
  }

  /// Adds the pullback to texels_adjoint, [height · width, 3]; the same bits for any number of threads.
  /// \param pyramid_adjoint  [texel_count, 3]; taken by value, since coarse levels flow into finer ones
  /// \throws ShapeError if an array does not fit the layout
  template <std::floating_point T>
  void adjoint(Array<T, 2> pyramid_adjoint, Array<T, 2>& texels_adjoint) const {
    require_shape("MipPyramid::adjoint", "pyramid_adjoint", pyramid_adjoint, {texel_count_, 3});
    require_shape("MipPyramid::adjoint", "texels_adjoint", texels_adjoint,
                  {layout_.height * layout_.width, 3});
    T* const adjoints = pyramid_adjoint.data();
    if (!shares_.empty())
      for (const detail::MipStep& step : steps_)
        step.for_each_row(true, [&](std::size_t i) {
          step.visit_children(i, [&](std::size_t coarse, std::size_t fine) {
            if (shares_[fine] != 0) return;
            add(T(1), adjoints + 3 * fine, adjoints + 3 * coarse);
            std::fill_n(adjoints + 3 * fine, 3, T(0));
          });
        });
    for (auto step = steps_.rbegin(); step != steps_.rend(); ++step)
      step->for_each_row(step->rows_are_apart(), [&](std::size_t i) {
        step->visit_row(i, [&](std::size_t coarse, std::size_t fine, double weight) {
          add(static_cast<T>(weight * part_of(fine, coarse)), adjoints + 3 * coarse, adjoints + 3 * fine);
        });
      });
    parallel_for_blocks(texels_adjoint.size(), 8192, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) texels_adjoint.data()[i] += adjoints[i];
    });
  }

 private:
  template <std::floating_point T>
  static void add(T weight, const T* from, T* to) {
    for (std::size_t c = 0; c < 3; ++c) to[c] += weight * from[c];
  }

  /// Weight of a fine texel's used part in a coarse texel, in equal areas.
  [[nodiscard]] double part_of(std::size_t fine, std::size_t coarse) const;

  TextureLayout layout_;
  std::vector<detail::MipStep> steps_;  ///< from the finest level up
  std::vector<double> shares_;          ///< used share of each texel's area; empty: all of it
  std::size_t texel_count_ = 0;
};

/// An atlas whose unused texels take the colours around them, so that no viewer that filters it shows seams.
///
/// \param used    [height, width], 0 where no face refers to a texel; if there is none, nothing changes
/// \param texels  [height · width, 3]
/// \throws ShapeError if an array does not fit the layout
template <std::floating_point T>
[[nodiscard]] Array<T, 2> with_unused_filled(const TextureLayout& layout, const Array<T, 2>& used,
                                             const Array<T, 2>& texels);

/// The texels that operators of views take: all levels of a pyramid, or, without one, the texture's own.
/// \throws ShapeError as the pyramid does
template <std::floating_point T>
[[nodiscard]] Array<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                        Array<T, 2> texels) {
  return pyramid ? (*pyramid)(texels) : texels;
}

/// stored_texels() on the active tape, which keeps the pyramid alive; its pullback is MipPyramid::adjoint().
/// Passive texels record nothing.
/// \throws ShapeError as the pyramid does
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                                const ArrayVariable<T, 2>& texels);

}  // namespace tapestry::raster

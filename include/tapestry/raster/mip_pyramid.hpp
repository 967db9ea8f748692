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
  std::vector<double> parts;  ///< of a coarse texel that each fine one makes up, as visit_row() visits them
  std::vector<std::size_t> first_part;  ///< by coarse row

  MipStep(const MipLevel& finer, const MipLevel& coarser);

  /// Calls visit(coarse texel, fine texel, part) for the coarse texels of a row.
  template <class Visit>
  void visit_row(std::size_t i, Visit visit) const {
    visit_row(*this, i, visit);
  }
  template <class Visit>
  void visit_row(std::size_t i, Visit visit) {
    visit_row(*this, i, visit);
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

 private:
  template <class Step, class Visit>
  static void visit_row(Step& step, std::size_t i, Visit& visit) {
    const MipOverlap& row = step.rows[i];
    auto* part = step.parts.data() + step.first_part[i];
    for (std::size_t j = 0; j < step.coarse.width; ++j) {
      const std::size_t coarse = step.coarse.first_texel + i * step.coarse.width + j;
      std::size_t first = step.fine.first_texel + row.first * step.fine.width + step.columns[j].first;
      for (std::size_t y = 0; y < row.count; ++y, first += step.fine.width)
        for (std::size_t x = 0; x < step.columns[j].count; ++x) visit(coarse, first + x, *part++);
    }
  }
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
    std::vector<double> shares(texel_count_, 0.0);  // used share of each texel's area
    for (std::size_t i = 0; i < used.size(); ++i) shares[i] = used.data()[i] != T(0) ? 1.0 : 0.0;
    for (detail::MipStep& step : steps_) {
      for (std::size_t i = 0; i < step.coarse.height; ++i)
        step.visit_row(i, [&](std::size_t coarse, std::size_t fine, double& part) {
          shares[coarse] += part * shares[fine];
        });
      for (std::size_t i = 0; i < step.coarse.height; ++i)
        step.visit_row(i, [&](std::size_t coarse, std::size_t fine, double& part) {
          part = shares[fine] == 0 ? 0 : part * (shares[fine] / shares[coarse]);
        });
    }
    for (const double share : shares) is_used_.push_back(share == 0 ? std::uint8_t{0} : std::uint8_t{1});
  }

  /// Texels of all levels.
  [[nodiscard]] std::size_t texel_count() const { return texel_count_; }

  /// \param texels  [height · width, 3]
  /// \returns       [texel_count, 3], for operators of a filtered layout
  /// \throws ShapeError if texels does not fit the layout
  template <std::floating_point T>
  [[nodiscard]] Array<T, 2> operator()(const Array<T, 2>& texels) const {
    require_shape("MipPyramid", "texels", texels, {layout_.height * layout_.width, 3});
    Array<T, 2> pyramid(Extents<2>{texel_count_, 3});
    T* const colours = pyramid.data();
    std::copy_n(texels.data(), texels.size(), colours);
    std::fill(colours + texels.size(), colours + pyramid.size(), T(0));
    for (const detail::MipStep& step : steps_)
      step.for_each_row(true, [&](std::size_t i) {
        step.visit_row(i, [&](std::size_t coarse, std::size_t fine, double part) {
          if (part > 0) add(static_cast<T>(part), colours + 3 * fine, colours + 3 * coarse);
        });
      });
    if (is_used_.empty()) return pyramid;
    for (auto step = steps_.rbegin(); step != steps_.rend(); ++step)
      step->for_each_row(true, [&](std::size_t i) {
        step->visit_children(i, [&](std::size_t coarse, std::size_t fine) {
          if (is_used_[fine] == 0) std::copy_n(colours + 3 * coarse, 3, colours + 3 * fine);
        });
      });
    return pyramid;
  }

  /// Adds the pullback to texels_adjoint, [height · width, 3]; the same bits for any number of threads.
  /// \param pyramid_adjoint  [texel_count, 3]
  /// \throws ShapeError if an array does not fit the layout
  template <std::floating_point T>
  void adjoint(const Array<T, 2>& pyramid_adjoint, Array<T, 2>& texels_adjoint) const {
    require_shape("MipPyramid::adjoint", "pyramid_adjoint", pyramid_adjoint, {texel_count_, 3});
    require_shape("MipPyramid::adjoint", "texels_adjoint", texels_adjoint,
                  {layout_.height * layout_.width, 3});
    const std::size_t finest = texels_adjoint.size();
    // Levels flow into one another, all but the finest, which ends in texels_adjoint.
    Array<T, 1> coarser(Extents<1>{pyramid_adjoint.size() - finest});
    std::copy(pyramid_adjoint.data() + finest, pyramid_adjoint.data() + pyramid_adjoint.size(),
              coarser.data());
    const auto of_coarse = [&](std::size_t texel) { return coarser.data() + (3 * texel - finest); };
    for (std::size_t level = 0; level < steps_.size() && !is_used_.empty(); ++level)
      steps_[level].for_each_row(true, [&](std::size_t i) {
        steps_[level].visit_children(i, [&](std::size_t coarse, std::size_t fine) {
          if (is_used_[fine] != 0) return;
          if (level == 0) return add(T(1), pyramid_adjoint.data() + 3 * fine, of_coarse(coarse));
          add(T(1), of_coarse(fine), of_coarse(coarse));
          std::fill_n(of_coarse(fine), 3, T(0));
        });
      });
    const bool all_count = is_used_.empty() || steps_.empty();  // a picture of one texel has no coarser one
    parallel_for_blocks(finest / 3, 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        if (all_count || is_used_[i] != 0)
          add(T(1), pyramid_adjoint.data() + 3 * i, texels_adjoint.data() + 3 * i);
    });
    for (std::size_t level = steps_.size(); level-- > 0;)
      steps_[level].for_each_row(steps_[level].rows_are_apart(), [&](std::size_t i) {
        steps_[level].visit_row(i, [&](std::size_t coarse, std::size_t fine, double part) {
          T* const to = level == 0 ? texels_adjoint.data() + 3 * fine : of_coarse(fine);
          add(static_cast<T>(part), of_coarse(coarse), to);
        });
      });
  }

 private:
  template <std::floating_point T>
  static void add(T weight, const T* from, T* to) {
    for (std::size_t c = 0; c < 3; ++c) to[c] += weight * from[c];
  }

  TextureLayout layout_;
  std::vector<detail::MipStep> steps_;  ///< from the finest level up
  std::vector<std::uint8_t> is_used_;   ///< 0 where no face refers to any part; empty: all are
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

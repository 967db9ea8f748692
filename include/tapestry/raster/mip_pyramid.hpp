#pragma once
#include <tapestry/image/colour_space_variable.hpp>
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

  /// Calls visit(coarse texel, fine texel) for the unused fine texels whose corner lies in a coarse row: each
  /// once.
  template <class Visit>
  void visit_unused(std::size_t i, const std::vector<std::uint8_t>& is_used, Visit visit) const {
    const auto first_row = [&](std::size_t row) {
      return (row * fine.height + coarse.height - 1) / coarse.height;
    };
    for (std::size_t y = first_row(i); y < first_row(i + 1); ++y)
      for (std::size_t x = 0; x < fine.width; ++x)
        if (const std::size_t texel = fine.first_texel + y * fine.width + x; is_used[texel] == 0)
          visit(coarse.first_texel + i * coarse.width + x * coarse.width / fine.width, texel);
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
  /// \param space   the pyramid's colours; linear: it is that of linearised(texels)
  /// \returns       [texel_count, 3], for operators of a filtered layout
  /// \throws ShapeError if texels does not fit the layout
  template <std::floating_point T>
  [[nodiscard]] Array<T, 2> operator()(const Array<T, 2>& texels,
                                       image::ColourSpace space = image::ColourSpace::encoded) const {
    require_shape("MipPyramid", "texels", texels, {layout_.height * layout_.width, 3});
    Array<T, 2> pyramid(Extents<2>{texel_count_, 3});
    T* const colours = pyramid.data();
    const auto fill = [&](std::size_t first_row, std::size_t rows) {
      const std::size_t first = 3 * layout_.width * first_row, count = 3 * layout_.width * rows;
      if (space == image::ColourSpace::encoded) {
        std::copy_n(texels.data() + first, count, colours + first);
      } else {
        const image::detail::Linearise<T> body{texels.data() + first, colours + first};
        tapestry::detail::for_block<16>(count, body);
      }
    };
    std::fill(colours + texels.size(), colours + pyramid.size(), T(0));
    const std::size_t height = fine_rows();
    if (height == 0) parallel_for(layout_.height, [&](std::size_t row) { fill(row, 1); });
    for (const detail::MipStep& step : steps_)
      step.for_each_row(true, [&](std::size_t i) {
        if (step.fine.first_texel == 0 && height > 0)
          fill(i * height, height);  // while they are in the cache
        step.visit_row(i, [&](std::size_t coarse, std::size_t fine, double part) {
          if (part > 0) add(static_cast<T>(part), colours + 3 * fine, colours + 3 * coarse);
        });
      });
    if (is_used_.empty()) return pyramid;
    for (auto step = steps_.rbegin(); step != steps_.rend(); ++step)
      step->for_each_row(true, [&](std::size_t i) {
        step->visit_unused(i, is_used_, [&](std::size_t coarse, std::size_t fine) {
          std::copy_n(colours + 3 * coarse, 3, colours + 3 * fine);
        });
      });
    return pyramid;
  }

  /// Adds the pullback to texels_adjoint, [height · width, 3]; the same bits for any number of threads.
  /// \param pyramid_adjoint  [texel_count, 3]
  /// \param texels, pyramid  if the pyramid is linear: what operator() took and gave
  /// \throws ShapeError if an array does not fit the layout
  template <std::floating_point T>
  void adjoint(const Array<T, 2>& pyramid_adjoint, Array<T, 2>& texels_adjoint,
               const Array<T, 2>* texels = nullptr, const Array<T, 2>* pyramid = nullptr) const {
    require_shape("MipPyramid::adjoint", "pyramid_adjoint", pyramid_adjoint, {texel_count_, 3});
    require_shape("MipPyramid::adjoint", "texels_adjoint", texels_adjoint,
                  {layout_.height * layout_.width, 3});
    const Array<T, 1> coarser = coarser_adjoints(pyramid_adjoint);
    const std::size_t height = fine_rows(), rows = steps_.empty() ? 1 : steps_[0].coarse.height;
    const std::size_t together = height > 0 ? std::max<std::size_t>(1, 512 / layout_.width) : rows;
    parallel_for_blocks(rows, together, [&](std::size_t begin, std::size_t end) {
      const std::size_t row = 3 * layout_.width, first = begin * height * row;
      Array<T, 1> own(Extents<1>{height > 0 ? (end - begin) * height * row : texels_adjoint.size()});
      std::copy_n(pyramid_adjoint.data() + first, own.size(), own.data());
      for (std::size_t i = 0; i < own.size() / 3 && !is_used_.empty() && !steps_.empty(); ++i)
        if (is_used_[first / 3 + i] == 0) std::fill_n(own.data() + 3 * i, 3, T(0));
      for (std::size_t i = begin; i < end && !steps_.empty(); ++i)
        add_to_finer(steps_[0], i, coarser.data() - texels_adjoint.size(), own.data() - first);
      T* const to = texels_adjoint.data() + first;
      if (texels == nullptr) {
        for (std::size_t i = 0; i < own.size(); ++i) to[i] += own(i);
      } else {
        const image::detail::LinearisedPullback<T> body{texels->data() + first, pyramid->data() + first,
                                                        own.data(), to};
        tapestry::detail::for_block<16>(own.size(), body);
      }
    });
  }

 private:
  template <std::floating_point T>
  static void add(T weight, const T* from, T* to) {
    for (std::size_t c = 0; c < 3; ++c) to[c] += weight * from[c];
  }

  /// Adds the adjoints of a coarse row to those of its parts.
  template <std::floating_point T>
  static void add_to_finer(const detail::MipStep& step, std::size_t row, const T* coarser, T* finer) {
    step.visit_row(row, [&](std::size_t coarse, std::size_t fine, double part) {
      add(static_cast<T>(part), coarser + 3 * coarse, finer + 3 * fine);
    });
  }

  /// Adjoints of all levels but the finest, which flow into one another, the finer ones last.
  template <std::floating_point T>
  [[nodiscard]] Array<T, 1> coarser_adjoints(const Array<T, 2>& pyramid_adjoint) const {
    const std::size_t finest = 3 * layout_.height * layout_.width;
    Array<T, 1> coarser(Extents<1>{pyramid_adjoint.size() - finest});
    std::copy(pyramid_adjoint.data() + finest, pyramid_adjoint.data() + pyramid_adjoint.size(),
              coarser.data());
    const auto of_coarse = [&](std::size_t texel) { return coarser.data() + (3 * texel - finest); };
    for (std::size_t level = 0; level < steps_.size() && !is_used_.empty(); ++level)
      steps_[level].for_each_row(true, [&](std::size_t i) {
        steps_[level].visit_unused(i, is_used_, [&](std::size_t coarse, std::size_t fine) {
          if (level == 0) return add(T(1), pyramid_adjoint.data() + 3 * fine, of_coarse(coarse));
          add(T(1), of_coarse(fine), of_coarse(coarse));
          std::fill_n(of_coarse(fine), 3, T(0));
        });
      });
    for (std::size_t level = steps_.size(); level-- > 1;)
      steps_[level].for_each_row(steps_[level].rows_are_apart(), [&](std::size_t i) {
        add_to_finer(steps_[level], i, coarser.data() - finest, coarser.data() - finest);
      });
    return coarser;
  }

  /// Rows of the atlas that each row of the next coarser level covers; 0 if some row lies in two of them.
  [[nodiscard]] std::size_t fine_rows() const {
    if (steps_.empty() || !steps_[0].rows_are_apart()) return 0;
    return layout_.height / steps_[0].coarse.height;
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

/// The texels that operators of views take, in a colour space: all levels of a pyramid, or, without one, the
/// texture's own.
/// \param texels  [texel, 3], encoded
/// \throws ShapeError as the pyramid does
template <std::floating_point T>
[[nodiscard]] Array<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid, Array<T, 2> texels,
                                        image::ColourSpace space = image::ColourSpace::encoded) {
  return pyramid ? (*pyramid)(texels, space) : image::in_space(space, std::move(texels));
}

/// stored_texels() on the active tape, which keeps the pyramid alive; its pullback is MipPyramid::adjoint().
/// Passive texels record nothing.
/// \throws ShapeError as the pyramid does
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                                const ArrayVariable<T, 2>& texels,
                                                image::ColourSpace space = image::ColourSpace::encoded);

/// The same on a tape of duals, for the pyramid is a linear map of linear colours.
template <DualNumber D>
[[nodiscard]] ArrayVariable<D, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                                const ArrayVariable<D, 2>& texels,
                                                image::ColourSpace space = image::ColourSpace::encoded) {
  const auto colours = image::in_space(space, texels);
  if (!pyramid) return colours;
  return record_linear([pyramid](const auto& at) { return stored_texels(pyramid, at); }, colours);
}
}  // namespace tapestry::raster

#pragma once
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/detail/network/operators/roi_sampling.hpp>

namespace tapestry::nn {
/// Boxes of feature maps, resampled to one size. Differentiable by features and by boxes; the number of
/// samples, and the choice of the largest weighted pixel, count as constant.
template <std::floating_point T>
class RoiAlign : public Operation<T> {
 public:
  RoiAlign(const Shape& x, const Shape& boxes, const RoiSampling& rule)
      : Operation<T>({{{boxes[0], x[1], rule.rows, rule.columns}, ElementType::floating}}),
        x_(x),
        count_(boxes[0]),
        rule_(rule) {}

  /// \throws DomainError for a box that is not finite or lies in none of the pictures
  void forward(const ForwardCall<T>& call) const override {
    for (std::size_t box = 0; box < count_; ++box)
      require_sound(call.inputs[1].values, call.inputs[2].values, box);
    T* const out = call.outputs[0].values;
    const std::size_t plane = x_[2] * x_[3], pixels = rule_.rows * rule_.columns;
    parallel_for(count_, [&](std::size_t box) {
      const auto image = static_cast<std::size_t>(call.inputs[2].values[box]);
      const T* const maps = call.inputs[0].values + image * x_[1] * plane;
      T* const to = out + box * x_[1] * pixels;
      const bool takes_largest = rule_.takes_largest;
      const Grid grid = grid_of(call.inputs[1].values, box);
      std::fill_n(to, x_[1] * pixels, T(0));
      std::vector<double> sums(x_[1]);
      for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        std::fill(sums.begin(), sums.end(), 0.0);
        bool is_first = true;
        for_each_sample(grid, pixel, [&](const Sample& sample) {
          for (std::size_t c = 0; c < x_[1]; ++c) {
            double value = 0;
            for (std::size_t tap = 0; tap < 4; ++tap) {
              const double part =
                  sample.weight[tap] * static_cast<double>(maps[c * plane + sample.index[tap]]);
              value = takes_largest ? (tap == 0 ? part : std::max(value, part)) : value + part;
            }
            sums[c] = !takes_largest ? sums[c] + value : is_first ? value : std::max(sums[c], value);
          }
          is_first = false;
        });
        const double scale = takes_largest || grid.samples == 0 ? 1 : 1 / static_cast<double>(grid.samples);
        for (std::size_t c = 0; c < x_[1]; ++c) to[c * pixels + pixel] = static_cast<T>(sums[c] * scale);
      }
    });
  }

  /// Boxes one after the other, since they may share pixels.
  void adjoint(const AdjointCall<T>& call) const override {
    const T *const x = call.inputs[0].values, *const boxes = call.inputs[1].values;
    const T* const of_out = call.output_adjoints[0].values;
    T* const of_x = call.wants(0) ? call.accumulate(0) : nullptr;
    T* const of_boxes = call.wants(1) ? call.accumulate(1) : nullptr;
    const std::size_t plane = x_[2] * x_[3], pixels = rule_.rows * rule_.columns;
    for (std::size_t box = 0; box < count_; ++box) {
      const std::size_t first = static_cast<std::size_t>(call.inputs[2].values[box]) * x_[1] * plane;
      const Grid grid = grid_of(boxes, box);
      if (grid.samples == 0) continue;
      for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        const T* const adjoint = of_out + box * x_[1] * pixels + pixel;
        std::array<double, 4> box_slope{};
        T* const of_maps = of_x == nullptr ? nullptr : of_x + first;
        if (rule_.takes_largest)
          pull_largest(x + first, grid, pixel, adjoint, of_maps, box_slope);
        else
          pull_mean(x + first, grid, pixel, adjoint, of_maps, box_slope);
        if (of_boxes != nullptr)
          for (std::size_t k = 0; k < 4; ++k) of_boxes[4 * box + k] += static_cast<T>(box_slope[k]);
      }
    }
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {7, 0}; }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input < 2; }

 private:
  /// One sample: its four pixels, and how their weights move.
  struct Sample {
    std::array<std::size_t, 4> index;
    std::array<double, 4> weight, row_slope, column_slope;  ///< derivatives by the sample's place
    std::array<double, 2> row_by_ends, column_by_ends;  ///< derivatives of the place by both ends of the box

    /// Adds the slope by the box from those by the sample's place.
    void add_slope(double by_row, double by_column, std::array<double, 4>& box_slope) const {
      for (std::size_t k = 0; k < 2; ++k) {
        box_slope[2 * k] += by_column * column_by_ends[k];
        box_slope[2 * k + 1] += by_row * row_by_ends[k];
      }
    }
  };

  void require_sound(const T* boxes, const T* images, std::size_t box) const {
    for (std::size_t k = 0; k < 4; ++k)
      if (!std::isfinite(boxes[4 * box + k]))
        throw DomainError({"box ", box, " has a corner at ", boxes[4 * box + k]});
    if (!(images[box] >= 0 && images[box] < static_cast<T>(x_[0])))
      throw DomainError({"box ", box, " lies in picture ", index_text(images[box]), " of ", x_[0]});
  }

  /// The samples of a box, along both axes.
  struct Grid {
    detail::RoiAxis across, down;
    std::size_t samples = 0;  ///< samples of an output pixel; 0 for an empty or infinite box
  };

  [[nodiscard]] Grid grid_of(const T* boxes, std::size_t box) const {
    const auto end = [&](std::size_t k) { return static_cast<double>(boxes[4 * box + k]); };
    Grid grid{{end(0), end(2), rule_.columns, rule_}, {end(1), end(3), rule_.rows, rule_}};
    if (std::isfinite(grid.across.first + grid.across.bin + grid.down.first + grid.down.bin))
      grid.samples = grid.across.samples * grid.down.samples;
    return grid;
  }

  /// Calls visit(sample) for an output pixel's samples that lie in the picture.
  template <class Visit>
  void for_each_sample(const Grid& grid, std::size_t pixel, Visit visit) const {
    if (grid.samples == 0) return;
    const detail::RoiAxis &across = grid.across, &down = grid.down;
    const auto by_ends = [&](const detail::RoiAxis& axis, double share) {
      return std::array<double, 2>{rule_.scale * (axis.is_least ? 1 : 1 - share),
                                   axis.is_least ? 0 : rule_.scale * share};
    };
    const auto rows = down.inside(pixel / rule_.columns, x_[2]);
    const auto columns = across.inside(pixel % rule_.columns, x_[3]);
    for (std::size_t i = rows[0]; i < rows[1]; ++i)
      for (std::size_t j = columns[0]; j < columns[1]; ++j) {
        const double row_share = down.share(pixel / rule_.columns, i);
        const double column_share = across.share(pixel % rule_.columns, j);
        const detail::RoiTaps row(down.place(row_share), x_[2]), column(across.place(column_share), x_[3]);
        if (row.is_outside || column.is_outside) continue;
        const double r = row.share, c = column.share;
        const double row_moves = row.moves ? 1 : 0, column_moves = column.moves ? 1 : 0;
        const std::size_t width = x_[3];
        visit(Sample{{row.low * width + column.low, row.low * width + column.high,
                      row.high * width + column.low, row.high * width + column.high},
                     {(1 - r) * (1 - c), (1 - r) * c, r * (1 - c), r * c},
                     {-row_moves * (1 - c), -row_moves * c, row_moves * (1 - c), row_moves * c},
                     {-column_moves * (1 - r), column_moves * (1 - r), -column_moves * r, column_moves * r},
                     by_ends(down, row_share),
                     by_ends(across, column_share)});
      }
  }

  /// Adds the adjoint of an output pixel to its samples' pixels, unless that is null, and to its box.
  void pull_mean(const T* maps, const Grid& grid, std::size_t pixel, const T* adjoint, T* of_maps,
                 std::array<double, 4>& box_slope) const {
    const std::size_t plane = x_[2] * x_[3], pixels = rule_.rows * rule_.columns;
    const double scale = 1 / static_cast<double>(grid.samples);
    for_each_sample(grid, pixel, [&](const Sample& sample) {
      double by_row = 0, by_column = 0;
      for (std::size_t c = 0; c < x_[1]; ++c) {
        const double own = scale * static_cast<double>(adjoint[c * pixels]);
        for (std::size_t tap = 0; tap < 4; ++tap) {
          const std::size_t at = c * plane + sample.index[tap];
          if (of_maps != nullptr) of_maps[at] += static_cast<T>(own * sample.weight[tap]);
          by_row += own * sample.row_slope[tap] * static_cast<double>(maps[at]);
          by_column += own * sample.column_slope[tap] * static_cast<double>(maps[at]);
        }
      }
      sample.add_slope(by_row, by_column, box_slope);
    });
  }

  /// The same for the largest: the whole adjoint goes to that weighted pixel, of equal ones to the first.
  void pull_largest(const T* maps, const Grid& grid, std::size_t pixel, const T* adjoint, T* of_maps,
                    std::array<double, 4>& box_slope) const {
    const std::size_t plane = x_[2] * x_[3], pixels = rule_.rows * rule_.columns;
    for (std::size_t c = 0; c < x_[1]; ++c) {
      double largest = 0;
      std::size_t tap_of_largest = 4;
      Sample best{};
      for_each_sample(grid, pixel, [&](const Sample& sample) {
        for (std::size_t tap = 0; tap < 4; ++tap) {
          const double part = sample.weight[tap] * static_cast<double>(maps[c * plane + sample.index[tap]]);
          if (tap_of_largest < 4 && !(part > largest)) continue;
          largest = part;
          tap_of_largest = tap;
          best = sample;
        }
      });
      if (tap_of_largest == 4) continue;
      const std::size_t tap = tap_of_largest, at = c * plane + best.index[tap];
      const double own = static_cast<double>(adjoint[c * pixels]),
                   value = own * static_cast<double>(maps[at]);
      if (of_maps != nullptr) of_maps[at] += static_cast<T>(best.weight[tap] * own);
      best.add_slope(value * best.row_slope[tap], value * best.column_slope[tap], box_slope);
    }
  }

  Shape x_;
  std::size_t count_;
  RoiSampling rule_;
};

template <std::floating_point T>
void add_roi_align(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    const Shape &x = context.input(0).shape, &boxes = context.input(1).shape;
    if (x.size() != 4 || size_of(x) == 0 || boxes.size() != 2 || boxes[1] != 4 ||
        context.input(2).shape != Shape{boxes[0]})
      throw ShapeError({"features, boxes and their pictures are ", x, ", ", boxes, " and ",
                        context.input(2).shape, ", expected [N, C, H, W], [boxes, 4] and [boxes]"});
    context.require_type(1, ElementType::floating);
    context.require_type(2, ElementType::integer);
    const std::string mode = context.text("mode", "avg");
    if (mode != "avg" && mode != "max")
      throw DomainError({"mode is ", in_quotes(mode), ", expected avg or max"});
    const bool was_whole = context.opset() < 16;
    const std::string origin =
        context.text("coordinate_transformation_mode", was_whole ? "output_half_pixel" : "half_pixel");
    if (origin != "half_pixel" && origin != "output_half_pixel")
      throw DomainError({"coordinate_transformation_mode is ", in_quotes(origin)});
    const auto extent = [&](const char* name) { return static_cast<std::size_t>(context.integer(name, 1)); };
    const RoiSampling rule{mode == "max",
                           origin == "half_pixel",
                           extent("output_height"),
                           extent("output_width"),
                           static_cast<std::size_t>(context.integer("sampling_ratio", 0)),
                           context.number("spatial_scale", 1)};
    constexpr std::size_t most = std::size_t(1) << 22U;
    if (const std::size_t samples = rule.rows * rule.samples * rule.columns * rule.samples; samples > most)
      throw DomainError({samples, " samples a box, expected at most ", most});
    if (!std::isfinite(rule.scale)) throw DomainError({"spatial_scale is ", rule.scale});
    return std::make_unique<RoiAlign<T>>(x, boxes, rule);
  };
  table["RoiAlign"] = {LayoutRule::plain,
                       1,
                       false,
                       {{3, 3}},
                       make,
                       {{"output_height", 1, 4096}, {"output_width", 1, 4096}, {"sampling_ratio", 0, 4096}}};
}
}  // namespace tapestry::nn

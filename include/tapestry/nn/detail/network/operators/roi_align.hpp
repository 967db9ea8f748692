#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/detail/network/operators.hpp>
#include <vector>

namespace tapestry::nn {

/// How RoiAlign lays samples in a box. Source: onnx.ai, Operators.md, RoiAlign; He et al., "Mask R-CNN"
/// (2017).
struct RoiSampling {
  bool takes_largest = false;  ///< of the weighted pixels of all samples, instead of the samples' mean
  bool is_half_pixel = true;   ///< pixel centres lie at +½; if not, boxes are at least one pixel large
  std::size_t rows = 1, columns = 1;  ///< of the result
  std::size_t samples =
      0;  ///< of an output pixel, along each axis; 0: one for each pixel of the input that it covers
  double scale = 1;  ///< pixels of the input per unit of the boxes
};

namespace detail {

/// The two pixels between which a sample lies along one axis, and the share of the second.
struct RoiTaps {
  std::size_t low = 0, high = 0;
  double share = 0;
  bool is_outside = false;  ///< more than a pixel beyond the picture: it counts as 0
  bool moves = false;       ///< whether the share grows with the place

  RoiTaps(double place, std::size_t extent) {
    const auto last = static_cast<double>(extent) - 1;
    is_outside = !(place >= -1 && place <= static_cast<double>(extent));
    if (is_outside) return;
    const double inside = std::max(place, 0.0);
    low = std::min(static_cast<std::size_t>(inside), extent - 1);
    high = std::min(low + 1, extent - 1);
    if (inside < last) share = inside - static_cast<double>(low);
    moves = place > 0 && inside < last;
  }
};

/// A box along one axis of the input.
struct RoiAxis {
  double first = 0, bin = 0;
  std::size_t samples = 1;
  bool is_least = false;  ///< widened to one pixel
  std::size_t bins = 1;

  RoiAxis(double low, double high, std::size_t bins_of, const RoiSampling& rule) : bins(bins_of) {
    const double shift = rule.is_half_pixel ? 0.5 : 0;
    first = low * rule.scale - shift;
    double extent = high * rule.scale - shift - first;
    is_least = !rule.is_half_pixel && extent < 1;
    if (is_least) extent = 1;
    bin = extent / static_cast<double>(bins);
    constexpr double most = 4096;  // samples of a bin
    samples = rule.samples;
    if (samples == 0 && bin > 0) samples = static_cast<std::size_t>(std::min(std::ceil(bin), most));
  }
  /// Share of the box at which a sample lies.
  [[nodiscard]] double share(std::size_t index, std::size_t sample) const {
    return (static_cast<double>(index) + (static_cast<double>(sample) + 0.5) / static_cast<double>(samples)) /
           static_cast<double>(bins);
  }
  [[nodiscard]] double place(double share) const { return first + share * bin * static_cast<double>(bins); }
};

}  // namespace detail

/// Boxes of feature maps, resampled to one size. Differentiable by features and, unless it takes the largest,
/// by boxes; the number of samples, and which pixel is the largest, are held still.
template <std::floating_point T>
class RoiAlign : public Operation<T> {
 public:
  RoiAlign(const Shape& x, const Shape& boxes, const RoiSampling& rule)
      : Operation<T>({{{boxes[0], x[1], rule.rows, rule.columns}, ElementType::floating}}),
        x_(x),
        count_(boxes[0]),
        rule_(rule) {}

  void forward(const ForwardCall<T>& call) const override {
    T* const out = call.outputs[0].values;
    const std::size_t plane = x_[2] * x_[3], pixels = rule_.rows * rule_.columns;
    parallel_for(count_, [&](std::size_t box) {
      const T* const maps = call.inputs[0].values + image_of(call.inputs[2].values, box) * x_[1] * plane;
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
    T* const of_boxes = call.wants(1) && !rule_.takes_largest ? call.accumulate(1) : nullptr;
    const std::size_t plane = x_[2] * x_[3], pixels = rule_.rows * rule_.columns;
    for (std::size_t box = 0; box < count_; ++box) {
      const std::size_t first = image_of(call.inputs[2].values, box) * x_[1] * plane;
      const Grid grid = grid_of(boxes, box);
      if (grid.samples == 0) continue;
      for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        const T* const adjoint = of_out + box * x_[1] * pixels + pixel;
        if (rule_.takes_largest) {
          if (of_x != nullptr) pull_largest(x + first, grid, pixel, adjoint, of_x + first);
          continue;
        }
        const double scale = 1 / static_cast<double>(grid.samples);
        std::array<double, 4> box_slope{};
        for_each_sample(grid, pixel, [&](const Sample& sample) {
          double by_row = 0, by_column = 0;
          for (std::size_t c = 0; c < x_[1]; ++c) {
            const double own = scale * static_cast<double>(adjoint[c * pixels]);
            for (std::size_t tap = 0; tap < 4; ++tap) {
              const std::size_t at = first + c * plane + sample.index[tap];
              if (of_x != nullptr) of_x[at] += static_cast<T>(own * sample.weight[tap]);
              by_row += own * sample.row_slope[tap] * static_cast<double>(x[at]);
              by_column += own * sample.column_slope[tap] * static_cast<double>(x[at]);
            }
          }
          for (std::size_t k = 0; k < 2; ++k) {
            box_slope[2 * k] += by_column * sample.column_by_ends[k];
            box_slope[2 * k + 1] += by_row * sample.row_by_ends[k];
          }
        });
        if (of_boxes != nullptr)
          for (std::size_t k = 0; k < 4; ++k) of_boxes[4 * box + k] += static_cast<T>(box_slope[k]);
      }
    }
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {7, 0}; }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override {
    return input == 0 || (input == 1 && !rule_.takes_largest);
  }

 private:
  /// One sample: its four pixels, and how their weights move.
  struct Sample {
    std::array<std::size_t, 4> index;
    std::array<double, 4> weight, row_slope, column_slope;  ///< derivatives by the sample's place
    std::array<double, 2> row_by_ends, column_by_ends;  ///< derivatives of the place by both ends of the box
  };

  /// The picture that a box lies in; the nearest for a number out of range.
  [[nodiscard]] std::size_t image_of(const T* images, std::size_t box) const {
    const T image = images[box];
    return image > 0 ? std::min(static_cast<std::size_t>(std::min(image, T(1 << 30))), x_[0] - 1) : 0;
  }

  /// The samples of a box, along both axes.
  struct Grid {
    detail::RoiAxis across, down;
    std::size_t samples = 0;  ///< of an output pixel; 0 for a box that is empty or not finite
  };

  [[nodiscard]] Grid grid_of(const T* boxes, std::size_t box) const {
    const auto end = [&](std::size_t k) { return static_cast<double>(boxes[4 * box + k]); };
    Grid grid{{end(0), end(2), rule_.columns, rule_}, {end(1), end(3), rule_.rows, rule_}};
    if (std::isfinite(grid.across.first + grid.across.bin + grid.down.first + grid.down.bin))
      grid.samples = grid.across.samples * grid.down.samples;
    return grid;
  }

  /// Calls visit(sample) for those of an output pixel that lie in the picture.
  template <class Visit>
  void for_each_sample(const Grid& grid, std::size_t pixel, Visit visit) const {
    if (grid.samples == 0) return;
    const detail::RoiAxis &across = grid.across, &down = grid.down;
    const auto by_ends = [&](const detail::RoiAxis& axis, double share) {
      return std::array<double, 2>{rule_.scale * (axis.is_least ? 1 : 1 - share),
                                   axis.is_least ? 0 : rule_.scale * share};
    };
    for (std::size_t i = 0; i < down.samples; ++i)
      for (std::size_t j = 0; j < across.samples; ++j) {
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

  /// The adjoint goes to the pixel whose weighted value is the largest, of equals the first.
  void pull_largest(const T* maps, const Grid& grid, std::size_t pixel, const T* adjoint, T* of_maps) const {
    const std::size_t plane = x_[2] * x_[3], pixels = rule_.rows * rule_.columns;
    for (std::size_t c = 0; c < x_[1]; ++c) {
      double largest = 0, weight = 0;
      std::size_t place = plane;
      for_each_sample(grid, pixel, [&](const Sample& sample) {
        for (std::size_t tap = 0; tap < 4; ++tap) {
          const double part = sample.weight[tap] * static_cast<double>(maps[c * plane + sample.index[tap]]);
          if (place < plane && !(part > largest)) continue;
          largest = part;
          weight = sample.weight[tap];
          place = sample.index[tap];
        }
      });
      if (place < plane)
        of_maps[c * plane + place] += static_cast<T>(weight * static_cast<double>(adjoint[c * pixels]));
    }
  }

  Shape x_;
  std::size_t count_;
  RoiSampling rule_;
};

/// RoiAlign.
template <std::floating_point T>
void add_roi_align(OperatorTable<T>& table) {
  table["RoiAlign"] = {
      LayoutRule::plain,
      1,
      false,
      {{3, 3}},
      [](OperatorContext& context) {
        const Shape &x = context.input(0).shape, &boxes = context.input(1).shape;
        if (x.size() != 4 || size_of(x) == 0 || boxes.size() != 2 || boxes[1] != 4 ||
            context.input(2).shape != Shape{boxes[0]})
          throw ShapeError({"features, boxes and their pictures are ", x, ", ", boxes, " and ",
                            context.input(2).shape, ", expected [N, C, H, W], [boxes, 4] and [boxes]"});
        context.require_type(1, ElementType::floating);
        const std::string mode = context.text("mode", "avg");
        if (mode != "avg" && mode != "max")
          throw DomainError({"mode is ", in_quotes(mode), ", expected avg or max"});
        const bool was_whole = context.opset() < 16;
        const std::string origin =
            context.text("coordinate_transformation_mode", was_whole ? "output_half_pixel" : "half_pixel");
        if (origin != "half_pixel" && origin != "output_half_pixel")
          throw DomainError({"coordinate_transformation_mode is ", in_quotes(origin)});
        const auto extent = [&](const char* name) {
          return static_cast<std::size_t>(context.integer(name, 1));
        };
        const RoiSampling rule{mode == "max",
                               origin == "half_pixel",
                               extent("output_height"),
                               extent("output_width"),
                               static_cast<std::size_t>(context.integer("sampling_ratio", 0)),
                               context.number("spatial_scale", 1)};
        if (!std::isfinite(rule.scale)) throw DomainError({"spatial_scale is ", rule.scale});
        return std::make_unique<RoiAlign<T>>(x, boxes, rule);
      },
      {{"output_height", 1, 4096}, {"output_width", 1, 4096}, {"sampling_ratio", 0, 4096}}};
}

}  // namespace tapestry::nn

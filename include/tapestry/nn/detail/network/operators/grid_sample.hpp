#pragma once
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/detail/network/operators/resize_attributes.hpp>

namespace tapestry::nn {
/// How GridSample reads pictures between pixels and outside.
/// Source: onnx.ai, Operators.md, GridSample, and PyTorch's grid_sample, which it follows.
struct GridSampling {
  enum class Mode { nearest, linear, cubic };
  enum class Padding { zeros, border, reflection };
  Mode mode = Mode::linear;
  Padding padding = Padding::zeros;
  bool align_corners = false;  ///< −1 and 1 are the centres of the outermost pixels, not their outer edges
};

/// The pixels along one axis that make one sample.
struct GridTaps {
  std::size_t count = 0;
  std::size_t index[4] = {};
  double weight[4] = {};
  double slope[4] = {};  ///< derivative of the weight by the coordinate
};

namespace detail {
/// A coordinate reflected at the picture's ends as often as necessary.
/// \param slope  is multiplied by the derivative, 1 or −1
[[nodiscard]] inline double reflected(double x, std::size_t extent, bool align_corners, double& slope) {
  const double low = align_corners ? 0 : -0.5;
  const double span = static_cast<double>(extent) - (align_corners ? 1 : 0);
  if (span == 0) return slope = 0;
  const double away = std::abs(x - low), rest = std::fmod(away, span);
  const bool is_turned = std::fmod(std::floor(away / span), 2.0) != 0;
  if ((x < low) != is_turned) slope = -slope;
  return low + (is_turned ? span - rest : rest);
}

/// Adds the pixel at an integer coordinate, or the padding there.
inline void add_tap(const GridSampling& rule, std::size_t extent, double place, double weight, double slope,
                    GridTaps& taps) {
  const double last = static_cast<double>(extent) - 1;
  if (rule.padding == GridSampling::Padding::zeros && !(place >= 0 && place <= last)) return;
  double unused = 1;
  if (rule.padding == GridSampling::Padding::reflection)
    place = reflected(place, extent, rule.align_corners, unused);
  taps.index[taps.count] = static_cast<std::size_t>(std::clamp(place, 0.0, last));
  taps.weight[taps.count] = weight;
  taps.slope[taps.count++] = slope;
}

/// d cubic_weights() / dt
inline void cubic_slopes(double a, double t, double* slopes) {
  const auto near = [a](double d) { return (3 * (a + 2) * d - 2 * (a + 3)) * d; };
  const auto far = [a](double d) { return (3 * a * d - 10 * a) * d + 8 * a; };
  slopes[0] = far(1 + t);
  slopes[1] = near(t);
  slopes[2] = -near(1 - t);
  slopes[3] = -far(2 - t);
}

/// \param coordinate  of the grid, from −1 to 1 within the picture; NaN makes the sample NaN
[[nodiscard]] inline GridTaps grid_taps(const GridSampling& rule, std::size_t extent, double coordinate) {
  using Mode = GridSampling::Mode;
  GridTaps taps;
  const auto size = static_cast<double>(extent);
  double slope = (rule.align_corners ? size - 1 : size) / 2;
  double x = rule.align_corners ? (coordinate + 1) * slope : (coordinate + 1) * slope - 0.5;
  if (rule.mode != Mode::cubic && rule.padding == GridSampling::Padding::reflection)
    x = reflected(x, extent, rule.align_corners, slope);
  if (rule.mode != Mode::cubic && rule.padding != GridSampling::Padding::zeros) {
    if (x <= 0 || x >= size - 1) slope = 0;
    x = std::clamp(x, 0.0, size - 1);
  }
  if (x != x) {
    taps.count = 1;
    taps.weight[0] = taps.slope[0] = x;
    return taps;
  }
  x = std::clamp(x, -1e9, 1e9);  // farther out makes no difference
  const double first = std::floor(x), t = x - first;
  if (rule.mode == Mode::nearest) {
    add_tap(rule, extent, std::nearbyint(x), 1, 0, taps);
  } else if (rule.mode == Mode::linear) {
    add_tap(rule, extent, first, 1 - t, -slope, taps);
    add_tap(rule, extent, first + 1, t, slope, taps);
  } else {
    double weights[4], slopes[4];
    cubic_weights(-0.75, t, weights);
    cubic_slopes(-0.75, t, slopes);
    for (std::size_t i = 0; i < 4; ++i)
      add_tap(rule, extent, first - 1 + static_cast<double>(i), weights[i], slopes[i] * slope, taps);
  }
  return taps;
}

[[nodiscard]] inline GridSampling grid_sampling(OperatorContext& context) {
  GridSampling rule;
  const std::string mode = context.text("mode", "bilinear");
  const std::string padding = context.text("padding_mode", "zeros");
  rule.align_corners = context.flag("align_corners", 0);
  using Mode = GridSampling::Mode;
  using Padding = GridSampling::Padding;
  const bool is_cubic = mode == "bicubic" || mode == "cubic";
  if (mode != "nearest" && !is_cubic && mode != "bilinear" && mode != "linear")
    throw DomainError({"attribute 'mode' is ", in_quotes(mode)});
  if (padding != "zeros" && padding != "border" && padding != "reflection")
    throw DomainError({"attribute 'padding_mode' is ", in_quotes(padding)});
  if (mode == "nearest" || is_cubic) rule.mode = is_cubic ? Mode::cubic : Mode::nearest;
  if (padding != "zeros") rule.padding = padding == "border" ? Padding::border : Padding::reflection;
  return rule;
}
}  // namespace detail

/// GridSample: pictures [N, C, H, W] read at places [N, row, column, (x, y)], differentiably by both. At a
/// pixel's centre the linear mode takes the derivative towards larger coordinates; it is 0 where the border
/// is repeated, and for the nearest pixel.
template <std::floating_point T>
class GridSample : public Operation<T> {
 public:
  GridSample(const Operand& pictures, const Operand& grid, const GridSampling& rule)
      : Operation<T>({{{pictures.shape[0], pictures.shape[1], grid.shape[1], grid.shape[2]}, pictures.type}}),
        rule_(rule),
        in_(pictures.shape),
        places_(grid.shape[1] * grid.shape[2]) {}

  void forward(const ForwardCall<T>& call) const override {
    const std::size_t pixels = in_[2] * in_[3];
    parallel_for(in_[0] * places_, [&](std::size_t task) {
      const std::size_t image = task / places_, place = task % places_;
      const auto [columns, rows] = taps_of(call.inputs[1].values + 2 * task);
      for (std::size_t c = 0; c < in_[1]; ++c) {
        const T* const from = call.inputs[0].values + (image * in_[1] + c) * pixels;
        double sum = 0;
        for (std::size_t y = 0; y < rows.count; ++y)
          for (std::size_t x = 0; x < columns.count; ++x)
            sum += rows.weight[y] * columns.weight[x] *
                   static_cast<double>(from[rows.index[y] * in_[3] + columns.index[x]]);
        call.outputs[0].values[(image * in_[1] + c) * places_ + place] = static_cast<T>(sum);
      }
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const pictures = call.wants(0) ? call.accumulate(0) : nullptr;
    T* const grid = call.wants(1) ? call.accumulate(1) : nullptr;
    parallel_for(in_[0], [&](std::size_t image) {
      for (std::size_t place = 0; place < places_; ++place) {
        const std::size_t at = 2 * (image * places_ + place);
        const auto [columns, rows] = taps_of(call.inputs[1].values + at);
        double place_adjoint[2] = {0, 0};
        for (std::size_t c = 0; c < in_[1]; ++c)
          pull_back(call, image * in_[1] + c, place, columns, rows, pictures, place_adjoint);
        for (std::size_t i = 0; i < 2 && grid != nullptr; ++i)
          grid[at + i] += static_cast<T>(place_adjoint[i]);
      }
    });
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {3, 0}; }

 private:
  struct Taps {
    GridTaps columns, rows;
  };
  [[nodiscard]] Taps taps_of(const T* place) const {
    return {detail::grid_taps(rule_, in_[3], static_cast<double>(place[0])),
            detail::grid_taps(rule_, in_[2], static_cast<double>(place[1]))};
  }

  void pull_back(const AdjointCall<T>& call, std::size_t plane, std::size_t place, const GridTaps& columns,
                 const GridTaps& rows, T* pictures, double* place_adjoint) const {
    const auto g = static_cast<double>(call.output_adjoints[0].values[plane * places_ + place]);
    for (std::size_t y = 0; y < rows.count; ++y)
      for (std::size_t x = 0; x < columns.count; ++x) {
        const std::size_t pixel = plane * in_[2] * in_[3] + rows.index[y] * in_[3] + columns.index[x];
        const double value = g * static_cast<double>(call.inputs[0].values[pixel]);
        if (pictures != nullptr) pictures[pixel] += static_cast<T>(g * rows.weight[y] * columns.weight[x]);
        place_adjoint[0] += value * rows.weight[y] * columns.slope[x];
        place_adjoint[1] += value * rows.slope[y] * columns.weight[x];
      }
  }

  GridSampling rule_;
  Shape in_;
  std::size_t places_;
};

template <std::floating_point T>
void add_grid_sample(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    const Operand &x = context.input(0), &grid = context.input(1);
    const Shape &a = x.shape, &b = grid.shape;
    if (a.size() != 4 || b.size() != 4 || a[0] != b[0] || b[3] != 2 || size_of(a) == 0)
      throw ShapeError(
          {"pictures and grid are ", a, " and ", b, ", expected [N, C, H, W] and [N, rows, columns, 2]"});
    context.require_type(1, ElementType::floating);
    return std::make_unique<GridSample<T>>(x, grid, detail::grid_sampling(context));
  };
  table["GridSample"] = {LayoutRule::plain, 1, false, {{2, 2}}, make};
}
}  // namespace tapestry::nn

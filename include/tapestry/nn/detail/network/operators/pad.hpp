#pragma once
#include <tapestry/nn/detail/network/operators/views.hpp>

namespace tapestry::nn {
namespace detail {
/// A run of a padded axis: it follows the axis before padding, repeats one element or runs backwards.
struct PadRun {
  std::ptrdiff_t to = 0, from = 0, step = 0;
  std::size_t count = 0;
};

/// Source of element `at` of a padded axis, in the axis before padding, which has `extent` elements; −1 for
/// the constant.
[[nodiscard]] inline std::ptrdiff_t pad_source(const std::string& mode, std::ptrdiff_t at,
                                               std::ptrdiff_t extent) {
  if (at >= 0 && at < extent) return at;
  if (mode == "constant") return -1;
  if (mode == "edge") return at < 0 ? 0 : extent - 1;
  const auto modulo = [](std::ptrdiff_t value, std::ptrdiff_t period) {
    return (value % period + period) % period;
  };
  if (mode == "wrap") return modulo(at, extent);
  if (extent == 1) return 0;
  const std::ptrdiff_t turn = modulo(at, 2 * extent - 2);  // reflect: the ends are not repeated
  return turn < extent ? turn : 2 * extent - 2 - turn;
}

[[nodiscard]] inline std::vector<PadRun> pad_runs(const std::string& mode, std::ptrdiff_t extent,
                                                  std::ptrdiff_t before, std::ptrdiff_t padded) {
  std::vector<PadRun> runs;
  for (std::ptrdiff_t to = 0; to < padded; ++to) {
    const std::ptrdiff_t from = pad_source(mode, to - before, extent);
    if (from < 0) continue;
    if (from == to - before) {  // the axis itself
      const std::ptrdiff_t length = std::min(padded - to, extent - from);
      runs.push_back({to, from, 1, static_cast<std::size_t>(length)});
      to += length - 1;
      continue;
    }
    if (!runs.empty()) {
      PadRun& run = runs.back();
      const auto length = static_cast<std::ptrdiff_t>(run.count);
      if (run.count == 1 && run.to + 1 == to && std::abs(from - run.from) <= 1) run.step = from - run.from;
      if (run.to + length == to && run.from + length * run.step == from) {
        ++run.count;
        continue;
      }
    }
    runs.push_back({to, from, 0, 1});
  }
  return runs;
}

struct PadSettings {
  std::string mode;
  std::vector<std::int64_t> pads;  ///< zeros before each axis, then behind each
  std::vector<std::int64_t> axes;
  double fill = 0;
};

[[nodiscard]] inline PadSettings pad_settings(OperatorContext& context) {
  PadSettings settings{context.text("mode", "constant"), {}, {}};
  const std::string& mode = settings.mode;
  if (mode != "constant" && mode != "reflect" && mode != "edge" && mode != "wrap")
    throw DomainError({"mode is ", in_quotes(mode), ", expected 'constant', 'reflect', 'edge' or 'wrap'"});
  const bool has_operands = context.opset() >= 11;
  settings.pads = has_operands ? context.integers(1) : context.integers("pads");
  if (!has_operands) {
    settings.fill = context.number("value", 0);
  } else if (context.has_input(2) && context.constant(2).size() > 0) {
    settings.fill = context.constant(2).at(0);
  }
  if (has_operands && context.has_input(3)) {
    settings.axes = context.integers(3);
  } else {
    for (std::size_t axis = 0; axis < context.input(0).shape.size(); ++axis)
      settings.axes.push_back(static_cast<std::int64_t>(axis));
  }
  if (settings.pads.size() != 2 * settings.axes.size())
    throw ShapeError({"pads has ", settings.pads.size(), " elements, expected ", 2 * settings.axes.size()});
  return settings;
}

/// Every combination of one run of each axis.
[[nodiscard]] inline std::vector<Piece> pad_pieces(const std::vector<std::vector<PadRun>>& runs,
                                                   const Shape& from_shape, const Shape& to_shape) {
  const auto from_strides = strides_of(from_shape), to_strides = strides_of(to_shape);
  constexpr std::size_t most = std::size_t(1) << 16U;
  std::size_t count = 1;
  for (const auto& axis : runs) {
    count *= axis.size();
    if (count > most) throw DomainError("pads repeat the tensor too often");
  }
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < count; ++i) {
    LoopNest<2> nest;
    std::ptrdiff_t from = 0, to = 0;
    std::size_t rest = i;
    for (std::size_t axis = 0; axis < runs.size(); ++axis) {
      const PadRun& run = runs[axis][rest % runs[axis].size()];
      rest /= runs[axis].size();
      from += run.from * from_strides[axis];
      to += run.to * to_strides[axis];
      nest.loops.push_back({run.count, {run.step * from_strides[axis], to_strides[axis]}});
    }
    pieces.emplace_back(0, 0, from, to, nest);
  }
  return pieces;
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_pad(OperatorContext& context) {
  const Operand& x = context.input(0);
  const PadSettings settings = pad_settings(context);
  std::vector<std::int64_t> before(x.shape.size(), 0), behind(x.shape.size(), 0);
  for (std::size_t i = 0; i < settings.axes.size(); ++i) {
    const std::size_t axis = context.axis(settings.axes[i], x.shape.size());
    if (axis >= x.shape.size()) throw ShapeError("a scalar has no axes");
    for (const bool is_behind : {false, true}) {
      const std::int64_t pad = settings.pads[i + (is_behind ? settings.axes.size() : 0)];
      if (pad < -largest_window || pad > largest_window) throw DomainError({"pads are out of range: ", pad});
      (is_behind ? behind : before)[axis] = pad;
    }
  }
  Shape shape;
  std::vector<std::vector<PadRun>> runs;
  for (std::size_t axis = 0; axis < x.shape.size(); ++axis) {
    const auto extent = static_cast<std::ptrdiff_t>(x.shape[axis]);
    const std::ptrdiff_t padded = extent + before[axis] + behind[axis];
    shape.push_back(to_extent(padded));
    if (extent == 0 && padded > 0 && settings.mode != "constant")
      throw ShapeError({"axis ", axis, " of ", x.shape, " has nothing to pad with"});
  }
  require_room(shape);
  for (std::size_t axis = 0; axis < x.shape.size(); ++axis)
    runs.push_back(pad_runs(settings.mode, static_cast<std::ptrdiff_t>(x.shape[axis]), before[axis],
                            static_cast<std::ptrdiff_t>(shape[axis])));
  const Coverage coverage{false, settings.mode != "constant"};
  return std::make_unique<Rearrange<T>>(std::vector<typename Operation<T>::Result>{{shape, x.type}},
                                        pad_pieces(runs, x.shape, shape), coverage, 1,
                                        static_cast<T>(settings.fill));
}

/// Extents of a tensor's axes N, C, H and W, and the strides along them, however it is stored.
struct PictureAxes {
  std::size_t extents[4];
  std::ptrdiff_t strides[4];
  PictureAxes(const OperatorContext& context, const Shape& stored) {
    const auto all = strides_of(stored);
    for (std::size_t axis = 0; axis < 4; ++axis) {
      const std::size_t place = context.axis(static_cast<std::int64_t>(axis), 4);
      extents[axis] = stored[place];
      strides[axis] = all[place];
    }
  }
};

/// From a picture with many channels to a large one. The deep picture's channel is
///
///  (row in the block · block + column in the block) · channels of the wide one + channel of the wide one
///
/// or, if channels come first,
///
///  channel of the wide one · block² + row in the block · block + column in the block
[[nodiscard]] inline LoopNest<2> depth_space_nest(const PictureAxes& deep, const PictureAxes& wide,
                                                  std::size_t block, bool channels_first) {
  const auto size = static_cast<std::ptrdiff_t>(block);
  const auto channels = static_cast<std::ptrdiff_t>(wide.extents[1]);
  const std::ptrdiff_t channel = deep.strides[1] * (channels_first ? size * size : 1);
  const std::ptrdiff_t column = deep.strides[1] * (channels_first ? 1 : channels);
  LoopNest<2> nest;
  nest.loops = {{deep.extents[0], {deep.strides[0], wide.strides[0]}},
                {wide.extents[1], {channel, wide.strides[1]}},
                {deep.extents[2], {deep.strides[2], wide.strides[2] * size}},
                {block, {column * size, wide.strides[2]}},
                {deep.extents[3], {deep.strides[3], wide.strides[3] * size}},
                {block, {column, wide.strides[3]}}};
  return nest;
}

/// DepthToSpace, from pictures with many channels to large ones, and SpaceToDepth, back.
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_depth_space(OperatorContext& context, bool to_space) {
  const std::string mode = to_space ? context.text("mode", "DCR") : "DCR";
  if (mode != "DCR" && mode != "CRD")
    throw DomainError({"mode is ", in_quotes(mode), ", expected 'DCR' or 'CRD'"});
  if (!context.has_attribute("blocksize")) throw DomainError("attribute 'blocksize' is missing");
  const std::size_t block = to_extent(context.integer("blocksize", 1)), area = block * block;
  const Operand& x = context.input(0);
  if (x.shape.size() != 4) throw ShapeError({x.shape, " has not four axes"});
  const PictureAxes from(context, x.shape);
  const auto [images, channels, rows, columns] = from.extents;
  if (to_space ? channels % area != 0 : rows % block != 0 || columns % block != 0)
    throw ShapeError({"blocks of ", block, " do not fit ", channels, " channels of ", rows, " x ", columns});
  Shape shape = to_space ? Shape{images, channels / area, rows * block, columns * block}
                         : Shape{images, channels * area, rows / block, columns / block};
  if (context.channels_last()) shape = in_stored_order(shape);
  const PictureAxes to(context, shape);
  LoopNest<2> nest = depth_space_nest(to_space ? from : to, to_space ? to : from, block, mode == "CRD");
  for (auto& loop : nest.loops)
    if (!to_space) std::swap(loop.strides[0], loop.strides[1]);
  return std::make_unique<Rearrange<T>>(std::vector<typename Operation<T>::Result>{{shape, x.type}},
                                        std::vector<Piece>{Piece(0, 0, 0, 0, nest)}, Coverage{});
}
}  // namespace detail

template <std::floating_point T>
void add_pad_operators(OperatorTable<T>& table) {
  table["Pad"] = {LayoutRule::any, 1, false, {{1, 1}, {2, 3, 11}, {2, 4, 18}}, detail::make_pad<T>};
  for (const bool to_space : {false, true}) {
    const auto make = [=](OperatorContext& context) {
      return detail::make_depth_space<T>(context, to_space);
    };
    table[to_space ? "DepthToSpace" : "SpaceToDepth"] = {
        LayoutRule::any, 1, false, {{1, 1}}, make, {{"blocksize", 1, largest_extent}}};
  }
}
}  // namespace tapestry::nn

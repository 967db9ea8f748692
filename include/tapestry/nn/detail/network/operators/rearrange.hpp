#pragma once
#include <tapestry/nn/detail/network/axis_reduction.hpp>
#include <tapestry/nn/detail/network/operation.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::nn {
/// Copies elements from tensor 0 of a nest to tensor 1, in a cache-friendly order.
class StridedCopy {
 public:
  StridedCopy() = default;
  explicit StridedCopy(LoopNest<2> nest) : nest_(std::move(nest)) {
    auto& loops = nest_.loops;
    std::ranges::stable_sort(
        loops, [](const auto& a, const auto& b) { return std::abs(a.strides[1]) > std::abs(b.strides[1]); });
    nest_.simplify();
    for (const auto& loop : loops) is_onto_ = is_onto_ && (loop.strides[1] != 0 || loop.extent == 1);
    const auto by_rows = std::ranges::find_if(loops, [](const auto& loop) { return loop.strides[0] == 1; });
    is_transposition_ = loops.size() > 1 && loops.back().strides[1] == 1 && loops.back().strides[0] > 1 &&
                        by_rows != loops.end();
    if (is_transposition_) std::rotate(by_rows, by_rows + 1, loops.end() - 1);
  }

  /// to = from, or to += from, at all places of the nest.
  template <bool Adds, std::floating_point T>
  void run(const T* from, T* to) const {
    if (is_transposition_) return transpose<Adds>(from, to);
    const auto step = nest_.loops.back().strides;
    const auto body = [&](const auto& at, std::size_t count) {
      move<Adds>(from + at[0], to + at[1], step, count);
    };
    if (is_onto_) {
      parallel_for_each_run(nest_, body);
    } else {
      for_each_run(nest_, body);  // one place may be added to several times
    }
  }

 private:
  static constexpr std::size_t tile = 16;

  template <bool Adds, std::floating_point T>
  static void move(const T* from, T* to, const LoopNest<2>::Places& step, std::size_t count) {
    if (step[0] == 1 && step[1] == 1) {
      if constexpr (Adds) {
        kernels<T>().add(from, to, count);
      } else {
        std::memcpy(to, from, count * sizeof(T));
      }
      return;
    }
    for (std::size_t i = 0; i < count; ++i, from += step[0], to += step[1]) *to = Adds ? *to + *from : *from;
  }

  /// The last two loops step by one element in `from` and in `to`: tiles of them stay in the cache.
  template <bool Adds, std::floating_point T>
  void transpose(const T* from, T* to) const {
    LoopNest<2> outer;
    outer.loops.assign(nest_.loops.begin(), nest_.loops.end() - 2);
    const auto &rows = *(nest_.loops.end() - 2), &columns = nest_.loops.back();
    const std::size_t tiles = block_count(rows.extent, tile);
    parallel_for(outer.size() * tiles, [&](std::size_t task) {
      const auto place = outer.place_of(task / tiles);
      const BlockRange range = block_range(task % tiles, rows.extent, tile);
      for (std::size_t first = 0; first < columns.extent; first += 4 * tile) {
        const std::size_t last = std::min(first + 4 * tile, columns.extent);
        for (std::size_t row = range.begin; row < range.end; ++row) {
          const T* source = from + place[0] + row + first * static_cast<std::size_t>(columns.strides[0]);
          T* goal = to + place[1] + static_cast<std::ptrdiff_t>(row) * rows.strides[1];
          for (std::size_t column = first; column < last; ++column, source += columns.strides[0])
            goal[column] = Adds ? goal[column] + *source : *source;
        }
      }
    });
  }

  LoopNest<2> nest_;
  bool is_onto_ = true;
  bool is_transposition_ = false;
};

/// A box of elements that goes from an operand to a result.
struct Piece {
  std::size_t input = 0, output = 0;
  std::ptrdiff_t from = 0, to = 0;  ///< places of the first element
  StridedCopy forth{}, back{};

  Piece(std::size_t input_index, std::size_t output_index, std::ptrdiff_t from_place, std::ptrdiff_t to_place,
        const LoopNest<2>& nest)
      : input(input_index), output(output_index), from(from_place), to(to_place), forth(nest) {
    LoopNest<2> reverse = nest;
    for (auto& loop : reverse.loops) std::swap(loop.strides[0], loop.strides[1]);
    back = StridedCopy(std::move(reverse));
  }
};

/// Whether pieces cover all of the operands and results.
struct Coverage {
  bool of_inputs = true;   ///< whether each element of an operand is copied exactly once
  bool of_outputs = true;  ///< whether each element of a result is written
};

/// An operation that puts elements elsewhere: Transpose, Slice, Concat, Split, Pad and their like.
template <std::floating_point T>
class Rearrange : public Operation<T> {
 public:
  using Result = typename Operation<T>::Result;

  /// \param data_inputs  operands that pieces come from
  /// \param fill         value of results outside all pieces
  Rearrange(std::vector<Result> results, std::vector<Piece> pieces, Coverage coverage,
            std::size_t data_inputs = 1, T fill = 0)
      : Operation<T>(std::move(results)),
        pieces_(std::move(pieces)),
        coverage_(coverage),
        data_inputs_(data_inputs),
        fill_(fill) {}

  void forward(const ForwardCall<T>& call) const override {
    for (const auto& output : call.outputs)
      if (!coverage_.of_outputs) std::fill_n(output.values, output.size(), fill_);
    for (const Piece& piece : pieces_)
      piece.forth.run<false>(call.inputs[piece.input].values + piece.from,
                             call.outputs[piece.output].values + piece.to);
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const bool has_all =
        std::ranges::all_of(call.output_adjoints, [](const auto& output) { return output.is_there(); });
    for (std::size_t i = 0; i < data_inputs_; ++i) {
      if (!call.wants(i)) continue;
      const bool is_written = call.is_uninitialised[i] && coverage_.of_inputs && has_all;
      T* const to = is_written ? call.input_adjoints[i].values : call.accumulate(i);
      call.is_uninitialised[i] = false;
      for (const Piece& piece : pieces_) {
        const T* const from = call.output_adjoints[piece.output].values;
        if (piece.input != i || from == nullptr) continue;
        if (is_written) {
          piece.back.run<false>(from + piece.to, to + piece.from);
        } else {
          piece.back.run<true>(from + piece.to, to + piece.from);
        }
      }
    }
  }

  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input < data_inputs_; }

 private:
  std::vector<Piece> pieces_;
  Coverage coverage_;
  std::size_t data_inputs_;
  T fill_;
};

/// An operand that is repeated along some axes of its result: Expand and Tile.
template <std::floating_point T>
class Repeat : public Operation<T> {
 public:
  /// \param extents  of the result, with axes split so that each is either walked or repeated
  /// \param strides  of the operand along those, 0 where it is repeated
  Repeat(Shape result, ElementType type, const Shape& extents, const std::vector<std::ptrdiff_t>& strides)
      : Operation<T>({{std::move(result), type}}) {
    LoopNest<2> nest;
    const auto own = strides_of(extents);
    std::vector<bool> is_reduced;
    for (std::size_t axis = 0; axis < extents.size(); ++axis) {
      nest.loops.push_back({extents[axis], {strides[axis], own[axis]}});
      is_reduced.push_back(strides[axis] == 0 && extents[axis] != 1);
    }
    forth_ = StridedCopy(std::move(nest));
    back_ = AxisReduction(extents, is_reduced, strides);
  }

  void forward(const ForwardCall<T>& call) const override {
    forth_.run<false>(call.inputs[0].values, call.outputs[0].values);
  }
  void adjoint(const AdjointCall<T>& call) const override {
    sum_to(back_, call.output_adjoints[0].values, 1, call.is_uninitialised[0], call.input_adjoints[0].values);
    call.is_uninitialised[0] = false;
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }

 private:
  StridedCopy forth_;
  AxisReduction back_;
};
}  // namespace tapestry::nn

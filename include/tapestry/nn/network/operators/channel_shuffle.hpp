#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/network/operator_table.hpp>
#include <tapestry/nn/network/operators/channel_extents.hpp>

namespace tapestry::nn {

/// Channels in `groups` groups, one after the other, are taken in turn from each: channel i of group g
/// becomes channel i · groups + g. Source: Zhang, Zhou, Lin and Sun, "ShuffleNet" (2018), section 3.1.
template <std::floating_point T>
class ChannelShuffle : public Operation<T> {
 public:
  ChannelShuffle(const Operand& x, const ChannelExtents& extents, std::size_t groups)
      : Operation<T>({{x.shape, x.type}}), extents_(extents), groups_(groups) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    for_each_pair([&](std::size_t from, std::size_t to) { out[to] = in[from]; });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const adjoint = call.output_adjoints[0].values;
    T* const to = call.input_adjoints[0].values;
    if (call.is_fresh[0]) {
      for_each_pair([&](std::size_t i, std::size_t o) { to[i] = adjoint[o]; });
      call.is_fresh[0] = false;
    } else {
      for_each_pair([&](std::size_t i, std::size_t o) { to[i] += adjoint[o]; });
    }
  }

 private:
  /// Calls body(element of the operand, that of the result).
  template <class Body>
  void for_each_pair(Body body) const {
    constexpr std::size_t at_once = 256;
    const std::size_t of_group = extents_.channels / groups_;
    const std::size_t pixels = extents_.images * extents_.pixels;
    parallel_for(block_count(pixels, at_once), [&](std::size_t block) {
      const BlockRange range = block_range(block, pixels, at_once);
      for (std::size_t pixel = range.begin; pixel < range.end; ++pixel) {
        const std::size_t first = pixel * extents_.channels;
        for (std::size_t g = 0; g < groups_; ++g)
          for (std::size_t i = 0; i < of_group; ++i) body(first + g * of_group + i, first + i * groups_ + g);
      }
    });
  }

  ChannelExtents extents_;
  std::size_t groups_;
};

/// ChannelShuffle, which is Tapestry's and none of ONNX's: simplified() makes it.
template <std::floating_point T>
void add_channel_shuffle(OperatorTable<T>& table) {
  table["ChannelShuffle"] = {
      LayoutRule::channels_last, 1, false, [](OperatorContext& context) {
        const ChannelExtents extents = channel_extents(context);
        const std::int64_t groups = context.integer("group", 1);
        if (!extents.is_last || groups < 1 || extents.channels % static_cast<std::size_t>(groups) != 0)
          throw DomainError("attribute 'group' is " + std::to_string(groups) + " for " +
                            std::to_string(extents.channels) + " channels");
        return std::make_unique<ChannelShuffle<T>>(context.input(0), extents,
                                                   static_cast<std::size_t>(groups));
      }};
}

}  // namespace tapestry::nn

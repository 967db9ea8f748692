#pragma once
#include <tapestry/nn/detail/network/operators/channel_extents.hpp>
#include <tapestry/nn/detail/network/operators/kernel_attributes.hpp>

namespace tapestry::nn {
/// Takes the channels of `groups` consecutive groups in turn from each group: channel i of group g becomes
/// channel i · groups + g. Source: Zhang, Zhou, Lin and Sun, "ShuffleNet" (2018), section 3.1.
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
    if (call.is_uninitialised[0]) {
      for_each_pair([&](std::size_t i, std::size_t o) { to[i] = adjoint[o]; });
      call.is_uninitialised[0] = false;
    } else {
      for_each_pair([&](std::size_t i, std::size_t o) { to[i] += adjoint[o]; });
    }
  }

 private:
  /// Calls body(element of the operand, element of the result).
  template <class Body>
  void for_each_pair(Body body) const {
    constexpr std::size_t at_once = 256;
    const std::size_t of_group = extents_.channels / groups_;
    const std::size_t pixels = extents_.images * extents_.pixels;
    parallel_for_blocks(pixels, at_once, [&](std::size_t begin, std::size_t end) {
      for (std::size_t pixel = begin; pixel < end; ++pixel) {
        const std::size_t first = pixel * extents_.channels;
        for (std::size_t g = 0; g < groups_; ++g)
          for (std::size_t i = 0; i < of_group; ++i) body(first + g * of_group + i, first + i * groups_ + g);
      }
    });
  }

  ChannelExtents extents_;
  std::size_t groups_;
};

/// ChannelShuffle, an operator of Tapestry, not of ONNX: simplified() makes it.
template <std::floating_point T>
void add_channel_shuffle(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    const ChannelExtents extents = channel_extents(context);
    const std::int64_t groups = context.integer("group", 1);
    if (!extents.is_last || extents.channels % static_cast<std::size_t>(groups) != 0)
      throw DomainError({"attribute 'group' is ", groups, " for ", extents.channels, " channels"});
    return std::make_unique<ChannelShuffle<T>>(context.input(0), extents, static_cast<std::size_t>(groups));
  };
  table["ChannelShuffle"] = {LayoutRule::channels_last,     1, false, {{1, 1}}, make,
                             {{"group", 1, largest_extent}}};
}

/// The channels of two tensors [pixels, channels] in turn, cut into results one after the other.
template <std::floating_point T>
class InterleaveChannels : public Operation<T> {
 public:
  using Result = typename Operation<T>::Result;

  /// \param results together of twice the channels
  InterleaveChannels(const Shape& shape, std::vector<Result> results)
      : Operation<T>(std::move(results)), channels_(shape.back()), pixels_(size_of(shape) / channels_) {
    this->set_pixelwise();
  }

  void forward(const ForwardCall<T>& call) const override {
    const T* const even = call.inputs[0].values;
    const T* const odd = call.inputs[1].values;
    for_each_run([&](std::size_t pixel, std::size_t result, std::size_t begin, std::size_t end) {
      kernels<T>().interleave(even + pixel * channels_, odd + pixel * channels_, begin, end,
                              call.outputs[result].values + pixel * (end - begin));
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const even = call.wants(0) ? call.accumulate(0) : nullptr;
    T* const odd = call.wants(1) ? call.accumulate(1) : nullptr;
    for_each_run([&](std::size_t pixel, std::size_t result, std::size_t begin, std::size_t end) {
      if (!call.output_adjoints[result].is_there()) return;
      const T* const from = call.output_adjoints[result].values + pixel * (end - begin);
      kernels<T>().interleave_adjoint(from, begin, end, even == nullptr ? nullptr : even + pixel * channels_,
                                      odd == nullptr ? nullptr : odd + pixel * channels_);
    });
  }

 private:
  /// Calls body(pixel, result, its first channel, the one behind its last).
  template <class Body>
  void for_each_run(Body body) const {
    constexpr std::size_t at_once = 256;
    parallel_for_blocks(pixels_, at_once, [&](std::size_t first, std::size_t last) {
      for (std::size_t pixel = first; pixel < last; ++pixel) {
        std::size_t begin = 0;
        for (std::size_t i = 0; i < this->results().size(); ++i) {
          const std::size_t end = begin + this->result_shape(i).back();
          body(pixel, i, begin, end);
          begin = end;
        }
      }
    });
  }

  std::size_t channels_, pixels_;
};

/// InterleaveChannels, which simplified() makes of Concat, ChannelShuffle in two groups and Split: its
/// attribute `split` holds the channels of each result.
template <std::floating_point T>
void add_interleave_channels(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    const Shape& shape = picture_shape(context);
    if (context.input(1).shape != shape)
      throw ShapeError({"input 1 is ", context.input(1).shape, ", expected ", shape});
    std::vector<typename Operation<T>::Result> results;
    std::size_t total = 0;
    const auto twice = static_cast<std::int64_t>(2 * shape.back());
    for (const std::int64_t channels : context.integers("split", {twice})) {
      results.push_back(
          {{shape[0], shape[1], shape[2], static_cast<std::size_t>(channels)}, ElementType::floating});
      total += results.back().shape.back();
    }
    if (total != 2 * shape.back())
      throw ShapeError({"attribute 'split' sums to ", total, ", expected ", twice});
    return std::make_unique<InterleaveChannels<T>>(shape, std::move(results));
  };
  table["InterleaveChannels"] = {LayoutRule::channels_last,     2, false, {{2, 2}}, make,
                                 {{"split", 1, largest_extent}}};
}
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/operators/channel_extents.hpp>

namespace tapestry::nn {
/// GroupNormalization and InstanceNormalization: scale · (x − mean)/√(variance + ε) + bias, with the mean and
/// the biased variance of each image's groups of channels, summed in double.
template <std::floating_point T>
class GroupNormalization : public Operation<T> {
 public:
  /// \param channels_per_weight  channels that share a value of scale and of bias
  GroupNormalization(const Shape& shape, const ChannelExtents& extents, std::size_t groups,
                     std::size_t channels_per_weight, double epsilon)
      : Operation<T>({{shape, ElementType::floating}}),
        extents_(extents),
        groups_(groups),
        channels_per_weight_(channels_per_weight),
        epsilon_(epsilon) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    parallel_for(extents_.images * groups_, [&](std::size_t task) {
      const Statistics statistics = statistics_of(task, in);
      for_each(task, [&](std::size_t i, std::size_t c) {
        const double normal = (static_cast<double>(in[i]) - statistics.mean) * statistics.inverse;
        out[i] = static_cast<T>(normal * weight(call.inputs[1], c) + weight(call.inputs[2], c));
      });
    });
  }

  /// With x̂ the normalised values and g their adjoints: ∂L/∂x = s · (g − mean(g) − x̂ · mean(g·x̂)).
  void adjoint(const AdjointCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    const T* const adjoint = call.output_adjoints[0].values;
    T* const to = call.wants(0) ? call.accumulate(0) : nullptr;
    const std::size_t count = extents_.images * extents_.channels;
    std::vector<double> sums(count, 0), products(count, 0);  // Σ of y's adjoint, and of that · x̂
    parallel_for(extents_.images * groups_, [&](std::size_t task) {
      const Statistics statistics = statistics_of(task, in);
      const std::size_t image = task / groups_ * extents_.channels;
      double sum = 0, product = 0;
      const auto normal = [&](std::size_t i) {
        return (static_cast<double>(in[i]) - statistics.mean) * statistics.inverse;
      };
      for_each(task, [&](std::size_t i, std::size_t c) {
        const auto g = static_cast<double>(adjoint[i]);
        sums[image + c] += g;
        products[image + c] += g * normal(i);
        sum += g * weight(call.inputs[1], c);
        product += g * normal(i) * weight(call.inputs[1], c);
      });
      if (to == nullptr) return;
      for_each(task, [&](std::size_t i, std::size_t c) {
        const double g = static_cast<double>(adjoint[i]) * weight(call.inputs[1], c);
        to[i] += static_cast<T>(statistics.inverse *
                                (g - (sum + normal(i) * product) / static_cast<double>(group_size())));
      });
    });
    hand_on(call, 1, products);
    hand_on(call, 2, sums);
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {0b11, 0}; }
  [[nodiscard]] bool is_weight(std::size_t input) const override { return input == 1 || input == 2; }

 private:
  struct Statistics {
    double mean = 0, inverse = 0;
  };

  [[nodiscard]] std::size_t group_size() const { return extents_.channels / groups_ * extents_.pixels; }

  /// Calls body(element, channel) for the elements of one group of one image.
  template <class Body>
  void for_each(std::size_t task, Body body) const {
    const std::size_t image = task / groups_, channels = extents_.channels / groups_;
    const std::size_t first = task % groups_ * channels;
    if (extents_.is_last) {
      for (std::size_t p = 0; p < extents_.pixels; ++p)
        for (std::size_t c = first; c < first + channels; ++c) body(extents_.at(image, c, p), c);
    } else {
      for (std::size_t c = first; c < first + channels; ++c)
        for (std::size_t p = 0; p < extents_.pixels; ++p) body(extents_.at(image, c, p), c);
    }
  }

  [[nodiscard]] Statistics statistics_of(std::size_t task, const T* in) const {
    const auto count = static_cast<double>(group_size());
    double sum = 0, squares = 0;
    for_each(task, [&](std::size_t i, std::size_t) { sum += static_cast<double>(in[i]); });
    const double mean = sum / count;
    for_each(task, [&](std::size_t i, std::size_t) {
      const double off = static_cast<double>(in[i]) - mean;
      squares += off * off;
    });
    return {mean, 1 / std::sqrt(squares / count + epsilon_)};
  }

  [[nodiscard]] double weight(const TensorView<const T>& weights, std::size_t channel) const {
    return static_cast<double>(weights.values[channel / channels_per_weight_]);
  }

  void hand_on(const AdjointCall<T>& call, std::size_t input, const std::vector<double>& values) const {
    if (!call.wants(input)) return;
    T* const to = call.accumulate(input);
    std::vector<double> joined(extents_.channels / channels_per_weight_, 0);
    for (std::size_t i = 0; i < values.size(); ++i)
      joined[i % extents_.channels / channels_per_weight_] += values[i];
    for (std::size_t i = 0; i < joined.size(); ++i) to[i] += static_cast<T>(joined[i]);
  }

  ChannelExtents extents_;
  std::size_t groups_, channels_per_weight_;
  double epsilon_;
};

/// InstanceNormalization, and GroupNormalization with a weight a group (before the 21st opset) or a channel.
template <std::floating_point T>
void add_group_normalization(OperatorTable<T>& table) {
  const auto make_of_instances = [](OperatorContext& context) {
    const ChannelExtents extents = channel_extents(context);
    for (const std::size_t input : {1U, 2U}) require_channels(context, input, extents.channels);
    return std::make_unique<GroupNormalization<T>>(context.input(0).shape, extents, extents.channels,
                                                   std::size_t(1), context.number("epsilon", 1e-5));
  };
  table["InstanceNormalization"] = {LayoutRule::channels_last, 1, false, {{3, 3}}, make_of_instances};
  const auto make = [](OperatorContext& context) {
    context.ignore("stash_type");  // sums are in double
    const ChannelExtents extents = channel_extents(context);
    if (!context.has_attribute("num_groups")) throw DomainError("attribute 'num_groups' is missing");
    const auto groups = static_cast<std::size_t>(context.integer("num_groups", 1));
    if (groups > extents.channels || extents.channels % groups != 0)
      throw DomainError({"attribute 'num_groups' is ", groups, " for ", extents.channels, " channels"});
    const std::size_t weights = context.opset() < 21 ? groups : extents.channels;
    for (const std::size_t input : {1U, 2U}) require_channels(context, input, weights);
    return std::make_unique<GroupNormalization<T>>(
        context.input(0).shape, extents, groups, extents.channels / weights, context.number("epsilon", 1e-5));
  };
  table["GroupNormalization"] = {LayoutRule::channels_last,          1, false, {{3, 3}}, make,
                                 {{"num_groups", 1, largest_extent}}};
}
}  // namespace tapestry::nn

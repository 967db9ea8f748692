#pragma once
#include <tapestry/nn/detail/network/operators.hpp>

namespace tapestry::nn {
/// NonZero of values that are known beforehand: the places of those that are not 0, [axes, count], in
/// row-major order. Positions of computed values have no extents.
template <std::floating_point T>
class NonZero : public Operation<T> {
 public:
  NonZero(std::size_t axes, std::vector<std::vector<std::size_t>> places)
      : Operation<T>({{{axes, places.size()}, ElementType::integer}}), places_(std::move(places)) {}

  void forward(const ForwardCall<T>& call) const override {
    for (std::size_t i = 0; i < places_.size(); ++i)
      for (std::size_t axis = 0; axis < places_[i].size(); ++axis)
        call.outputs[0].values[axis * places_.size() + i] = static_cast<T>(places_[i][axis]);
  }
  [[nodiscard]] bool is_differentiable(std::size_t) const override { return false; }

 private:
  std::vector<std::vector<std::size_t>> places_;
};

template <std::floating_point T>
void add_non_zero(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
    const Operand& x = context.input(0);
    if (x.constant == nullptr)
      throw DomainError(
          "the number of values left depends on the picture, which is not supported; choose outputs before "
          "this node");
    std::vector<std::vector<std::size_t>> places;
    for (std::size_t i = 0; i < x.constant->size(); ++i) {
      if (x.constant->at(i) == 0) continue;
      auto& place = places.emplace_back(x.shape.size());
      std::size_t rest = i;
      for (std::size_t axis = x.shape.size(); axis-- > 0;) {
        place[axis] = rest % x.shape[axis];
        rest /= x.shape[axis];
      }
    }
    return std::make_unique<NonZero<T>>(x.shape.size(), std::move(places));
  };
  table["NonZero"] = {LayoutRule::plain, 1, false, {{1, 1}}, make};
}
}  // namespace tapestry::nn

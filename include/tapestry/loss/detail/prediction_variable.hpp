#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/loss/prediction.hpp>

namespace tapestry::loss::detail {
/// Logits of a batch on the tape, kept for a loss's pullback together with their heads, so that later changes
/// of the detector or the tape do not matter.
template <std::floating_point T>
class KeptLogits {
 public:
  KeptLogits(const std::vector<detect::Head>& heads, std::size_t input_height, std::size_t input_width,
             const std::vector<ArrayVariable<T, 4>>& logits)
      : heads_(heads), input_height_(input_height), input_width_(input_width) {
    for (const auto& head : logits) {
      arrays_.push_back(head.shared_value());
      view_.push_back(arrays_.back().get());
    }
  }

  [[nodiscard]] const std::vector<detect::Head>& heads() const { return heads_; }
  [[nodiscard]] const LogitsView<T>& view() const { return view_; }
  [[nodiscard]] Predictions<T> of_image(std::size_t image) const {
    return {heads_, view_, image, input_height_, input_width_};
  }

 private:
  std::vector<detect::Head> heads_;
  std::size_t input_height_, input_width_;
  std::vector<std::shared_ptr<const Array<T, 4>>> arrays_;
  LogitsView<T> view_;
};
}  // namespace tapestry::loss::detail

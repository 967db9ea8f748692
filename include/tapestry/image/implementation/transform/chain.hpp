#pragma once
#include <tapestry/image/batch.hpp>
#include <tapestry/image/transform/chain.hpp>

namespace tapestry::image {
namespace detail {
/// Factors of a pixel's encoded channels.
class LightFactors {
 public:
  LightFactors(const LightChange& change, std::size_t height, std::size_t width)
      : change_(change),
        across_(std::cos(change.shadow_rad)),
        down_(std::sin(change.shadow_rad)),
        middle_x_(static_cast<double>(width) / 2),
        middle_y_(static_cast<double>(height) / 2) {
    const bool is_light = change.gain[0] > 0 && change.gain[1] > 0 && change.gain[2] > 0;
    if (!is_light || !(change.shadow >= 0 && change.shadow < 1) || !(change.shadow_softness > 0))
      throw DomainError(
          "light change: gains and softness must be above 0, a "
          "shadow 0 to below 1");
    for (std::size_t c = 0; c < 3; ++c) gain_[c] = encoded(change.gain[c]);
  }

  [[nodiscard]] std::array<double, 3> operator()(std::size_t x, std::size_t y) const {
    if (change_.shadow == 0) return gain_;
    const double place = (across_ * (static_cast<double>(x) + 0.5 - middle_x_) +
                          down_ * (static_cast<double>(y) + 0.5 - middle_y_)) /
                         middle_x_;
    const double edge =
        std::clamp((place - change_.shadow_at) / (2 * change_.shadow_softness) + 0.5, 0.0, 1.0);
    if (edge == 0) return gain_;
    const double left = encoded(1 - change_.shadow * edge * edge * (3 - 2 * edge));
    return {gain_[0] * left, gain_[1] * left, gain_[2] * left};
  }

 private:
  static double encoded(double light) { return std::pow(light, 1 / 2.2); }

  LightChange change_;
  double across_, down_, middle_x_, middle_y_;
  std::array<double, 3> gain_{};
};
}  // namespace detail

template <std::floating_point T>
Array<T, 3> transformed(const Array<T, 3>& picture, const LightChange& change) {
  const std::size_t width = picture.shape(1);
  require_shape("transformed", "picture", picture, {picture.shape(0), width, 3});
  Array<T, 3> out(picture.shape());
  const detail::LightFactors factors(change, picture.shape(0), width);
  detail::for_each_row(picture.shape(0), [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const auto factor = factors(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        out(y, x, c) = std::min(T(1), static_cast<T>(factor[c]) * picture(y, x, c));
    }
  });
  return out;
}

template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const LightChange& change,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint) {
  const std::size_t width = picture.shape(1);
  require_shape("transformed_adjoint", "picture", picture, {picture.shape(0), width, 3});
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  const detail::LightFactors factors(change, picture.shape(0), width);
  detail::for_each_row(picture.shape(0), [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const auto factor = factors(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        if (const T slope = static_cast<T>(factor[c]); slope * picture(y, x, c) < 1)
          picture_adjoint(y, x, c) += slope * out_adjoint(y, x, c);
    }
  });
}

template <std::floating_point T>
std::vector<Array<T, 3>> transformation_stages(Array<T, 3> picture, const TransformationChain& chain) {
  std::vector<Array<T, 3>> stages;
  stages.reserve(chain.size() + 1);
  stages.push_back(std::move(picture));
  for (const Transformation& transformation : chain)
    stages.push_back(
        std::visit([&](const auto& one) { return transformed(stages.back(), one); }, transformation));
  return stages;
}

template <std::floating_point T>
Array<T, 3> transformed(Array<T, 3> picture, const TransformationChain& chain) {
  for (const Transformation& transformation : chain)
    picture = std::visit([&](const auto& one) { return transformed(picture, one); }, transformation);
  return picture;
}

template <std::floating_point T>
void transformed_adjoint(const std::vector<Array<T, 3>>& stages, const TransformationChain& chain,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint) {
  if (stages.size() != chain.size() + 1) throw ShapeError("transformed_adjoint: stages of another chain");
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, stages.back().shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, stages.back().shape());
  Array<T, 3> adjoint = out_adjoint;
  for (std::size_t i = chain.size(); i-- > 0;) {
    Array<T, 3> before = xt::zeros_like(adjoint);
    std::visit([&](const auto& one) { transformed_adjoint(stages[i], one, adjoint, before); }, chain[i]);
    adjoint = std::move(before);
  }
  for (std::size_t i = 0; i < adjoint.size(); ++i) picture_adjoint.data()[i] += adjoint.data()[i];
}

template <std::floating_point T>
ArrayVariable<T, 4> transformed(const ArrayVariable<T, 4>& pictures,
                                const std::vector<TransformationChain>& chains) {
  const Array<T, 4>& before = pictures.value();
  if (chains.size() != before.shape(0))
    throw ShapeError({"transformed: ", chains.size(), " chains for ", before.shape(0), " pictures"});
  std::vector<std::vector<Array<T, 3>>> stages(chains.size());
  Array<T, 4> out(before.shape());
  const std::size_t size = chains.empty() ? 0 : before.size() / chains.size();
  parallel_for(chains.size(), [&](std::size_t n) {
    stages[n] = transformation_stages(picture_of(before, n), chains[n]);
    std::copy_n(stages[n].back().data(), size, out.data() + n * size);
  });
  const auto pullback = [stages = std::move(stages), chains, size](const Array<T, 4>& out_adjoint,
                                                                   Array<T, 4>* pictures_adjoint) {
    parallel_for(chains.size(), [&](std::size_t n) {
      Array<T, 3> adjoint = xt::zeros_like(stages[n].front());
      transformed_adjoint(stages[n], chains[n], picture_of(out_adjoint, n), adjoint);
      T* const to = pictures_adjoint->data() + n * size;
      for (std::size_t i = 0; i < size; ++i) to[i] += adjoint.data()[i];
    });
  };
  return record_array(std::move(out), pullback, pictures);
}
}  // namespace tapestry::image

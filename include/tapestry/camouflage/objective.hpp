#pragma once
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/network.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/smoothness.hpp>
#include <vector>

namespace tapestry::camouflage {

/// μ = 1 stands for this factor before the sum of squared colour steps. The paper prints μ = 1 and its
/// published program multiplies the sum by 1e-4; without the factor the sum, some thousands at 416
/// pixels, drowns adversarial terms that never exceed ten.
inline constexpr double smoothness_unit = 1e-4;

struct ObjectiveOptions {
  loss::AdversarialLoss kind = loss::AdversarialLoss::paper;
  loss::AdversarialWeights weights{};  ///< α, β, γ of the paper
  double smoothness = 1;               ///< μ, in units of smoothness_unit
  bool smooth_texture = false;         ///< steps are counted over the texture atlas instead of the picture
  std::size_t class_index = 0;         ///< the class that the car should no longer be found as
};

/// The terms of one minibatch, before their weights, averaged over its views.
struct ObjectiveTerms {
  double iou = 0;
  double objectness = 0;
  double classification = 0;
  double max_score = 0;
  double smoothness = 0;  ///< sum of squared colour steps
  double total = 0;       ///< with weights: what is minimised
};

/// The whole pipeline as one function on the tape:
///
///   parameter → colours → render → compose → detector → adversarial loss + μ · smoothness.
///
/// Source: FCA (AAAI 2022), eq. 2-7 and Algorithm 1. The network's weights, the frames and the cameras
/// are passive and record nothing.
template <class T>
class Objective {
 public:
  using Views = std::span<const View<T>* const>;

  /// The network must outlive the objective.
  /// \throws DomainError if the network has no class of that index, or gives no raw logits
  Objective(const detect::Network<T>& network, const raster::TextureLayout& layout, ObjectiveOptions options)
      : network_(network), layout_(layout), options_(options) {
    loss::require_raw_logits("objective", network.heads());
    for (const auto& head : network.heads())
      if (options.class_index >= head.classes)
        throw DomainError("objective: class " + std::to_string(options.class_index) + " of a network with " +
                          std::to_string(head.classes) + " classes");
  }

  /// Records the loss of a minibatch on the active tape and returns it.
  ///
  /// \param parameter  [texel, 3]
  /// \param views      at least one; they must outlive the tape's next reverse()
  [[nodiscard]] Variable<T> operator()(const ArrayVariable<T, 2>& parameter, Views views) {
    if (views.empty()) throw DomainError("objective: no views");
    const auto colours = timed(times_.update, [&] { return texture_colours(parameter); });
    const auto pictures = photograph(colours, views);
    const auto logits = detect_all(pictures);
    const Variable<T> adversarial = adversarial_term(logits, views);
    const Variable<T> smoothness =
        options_.smooth_texture ? texture_smoothness(colours) : picture_smoothness(pictures, views);
    const Variable<T> total =
        adversarial + static_cast<T>(options_.smoothness * smoothness_unit) * smoothness;
    terms_.smoothness = static_cast<double>(smoothness.value());
    terms_.total = static_cast<double>(total.value());
    return total;
  }

  /// The terms of the last call.
  [[nodiscard]] const ObjectiveTerms& terms() const { return terms_; }
  [[nodiscard]] StepTimes& times() { return times_; }
  [[nodiscard]] const ObjectiveOptions& options() const { return options_; }
  [[nodiscard]] const detect::Network<T>& network() const { return network_; }

  /// Pictures of a texture in the given views as the detector sees them, [N, 3, H, W].
  [[nodiscard]] static Array<T, 4> pictures_of(const Array<T, 2>& colours, Views views) {
    Array<T, 4> pictures(picture_extents(views));
    for (std::size_t n = 0; n < views.size(); ++n)
      compose(*views[n], raster::render(views[n]->picture, colours), picture_begin(pictures, n));
    return pictures;
  }

 private:
  template <class Action>
  static auto timed(double& seconds, Action action) {
    const ScopedTimer timer(seconds);
    return action();
  }

  static Extents<4> picture_extents(Views views) {
    return {views.size(), 3, views.front()->mask.shape(0), views.front()->mask.shape(1)};
  }

  template <class Pictures>
  static auto picture_begin(Pictures& pictures, std::size_t n) {
    return pictures.data() + n * pictures.shape(1) * pictures.shape(2) * pictures.shape(3);
  }

  [[nodiscard]] ArrayVariable<T, 4> photograph(const ArrayVariable<T, 2>& colours, Views views) {
    Array<T, 4> pictures(picture_extents(views));
    std::vector<Array<T, 3>> renders(views.size());
    timed(times_.render, [&] {
      parallel_for(views.size(),
                   [&](std::size_t n) { renders[n] = raster::render(views[n]->picture, colours.value()); });
    });
    timed(times_.compose, [&] {
      parallel_for(views.size(),
                   [&](std::size_t n) { compose(*views[n], renders[n], picture_begin(pictures, n)); });
    });
    return record_array<T, 4>(
        std::move(pictures),
        [this, views = std::vector<const View<T>*>(views.begin(), views.end())](
            const Array<T, 4>& adjoint, Array<T, 2>* colours_adjoint) {
          if (colours_adjoint == nullptr) return;
          std::vector<Array<T, 3>> render_adjoints(views.size());
          timed(times_.compose, [&] {
            parallel_for(views.size(), [&](std::size_t n) {
              render_adjoints[n] = compose_adjoint(*views[n], picture_begin(adjoint, n));
            });
          });
          const ScopedTimer timer(times_.render);
          add_render_adjoints(views, render_adjoints, *colours_adjoint);
        },
        colours);
  }

  /// A small texture's adjoints are summed view by view, so that views are independent of one another.
  static void add_render_adjoints(Views views, const std::vector<Array<T, 3>>& render_adjoints,
                                  Array<T, 2>& colours_adjoint) {
    constexpr std::size_t small_texture = 1U << 18U;  // values
    if (colours_adjoint.size() > small_texture) {
      for (std::size_t n = 0; n < views.size(); ++n)
        raster::render_adjoint(views[n]->picture, render_adjoints[n], colours_adjoint);
      return;
    }
    std::vector<Array<T, 2>> parts(views.size());
    parallel_for(views.size(), [&](std::size_t n) {
      parts[n] = zeros<T, 2>(colours_adjoint.shape());
      raster::render_adjoint(views[n]->picture, render_adjoints[n], parts[n]);
    });
    for (const auto& part : parts)
      for (std::size_t i = 0; i < part.size(); ++i) colours_adjoint.data()[i] += part.data()[i];
  }

  /// Every head's logits behind one another, so that the network is one record with one output.
  [[nodiscard]] ArrayVariable<T, 1> detect_all(const ArrayVariable<T, 4>& pictures) {
    timed(times_.detector_forward,
          [&] { network_.forward(pictures.value(), pass_, detect::Mode::input_gradient); });
    return record_array<T, 1>(
        joined(pass_.logits),
        [this](const Array<T, 1>& logits_adjoint, Array<T, 4>* pictures_adjoint) {
          if (pictures_adjoint == nullptr) return;
          const ScopedTimer timer(times_.detector_backward);
          network_.input_adjoint(pass_, separated(logits_adjoint), *pictures_adjoint);
        },
        pictures);
  }

  [[nodiscard]] loss::Predictions<T> predictions(std::size_t image) const {
    return {network_.heads(), loss::to_read(pass_.logits), image, network_.input_height(),
            network_.input_width()};
  }

  [[nodiscard]] Variable<T> adversarial_term(const ArrayVariable<T, 1>& logits, Views views) {
    const ScopedTimer timer(times_.losses);
    terms_ = {};
    std::vector<loss::Target> targets;
    for (const auto* view : views) targets.push_back({options_.class_index, view->target});
    std::vector<loss::AdversarialTerms<T>> terms(views.size());
    parallel_for(views.size(), [&](std::size_t n) {
      terms[n] = loss::adversarial(predictions(n), targets[n], options_.kind, options_.weights);
    });
    const double share = 1 / static_cast<double>(views.size());
    double total = 0;
    for (const auto& term : terms) {
      terms_.iou += share * static_cast<double>(term.iou);
      terms_.objectness += share * static_cast<double>(term.objectness);
      terms_.classification += share * static_cast<double>(term.classification);
      terms_.max_score += share * static_cast<double>(term.max_score);
      total += share * static_cast<double>(term.total);
    }
    return record_scalar<T>(
        static_cast<T>(total),
        [this, targets = std::move(targets), share](T adjoint, Array<T, 1>* logits_adjoint) {
          if (logits_adjoint == nullptr) return;
          const ScopedTimer pullback_timer(times_.losses);
          auto heads_adjoint = separated(*logits_adjoint);
          const auto addresses = loss::to_add_to(heads_adjoint);
          parallel_for(targets.size(), [&](std::size_t n) {
            loss::adversarial_adjoint(predictions(n), targets[n], options_.kind, options_.weights,
                                      adjoint * static_cast<T>(share), addresses);
          });
          *logits_adjoint = joined(heads_adjoint);
        },
        logits);
  }

  [[nodiscard]] Variable<T> picture_smoothness(const ArrayVariable<T, 4>& pictures, Views views) {
    const ScopedTimer timer(times_.losses);
    std::vector<double> sums(views.size());
    parallel_for(views.size(), [&](std::size_t n) {
      const auto part = window_of(*views[n], picture_begin(pictures.value(), n));
      sums[n] = static_cast<double>(loss::smoothness(part, car_pixels(*views[n])));
    });
    double mean = 0;
    for (const double sum : sums) mean += sum / static_cast<double>(views.size());
    return record_scalar<T>(
        static_cast<T>(mean),
        [this, values = pictures.shared_value(),
         views = std::vector<const View<T>*>(views.begin(), views.end())](T adjoint,
                                                                          Array<T, 4>* pictures_adjoint) {
          if (pictures_adjoint == nullptr) return;
          const ScopedTimer pullback_timer(times_.losses);
          parallel_for(views.size(), [&](std::size_t n) {
            const auto part = window_of(*views[n], picture_begin(*values, n));
            auto part_adjoint = zeros<T, 3>(part.shape());
            loss::smoothness_adjoint(part, car_pixels(*views[n]), adjoint / static_cast<T>(views.size()),
                                     part_adjoint);
            add_to_window(*views[n], part_adjoint, picture_begin(*pictures_adjoint, n));
          });
        },
        pictures);
  }

  [[nodiscard]] Variable<T> texture_smoothness(const ArrayVariable<T, 2>& colours) {
    if (layout_.kind != raster::TextureKind::atlas)
      throw DomainError("objective: smoothness over the texture needs an atlas");
    const ScopedTimer timer(times_.losses);
    const auto as_image = [extents =
                               Extents<3>{layout_.height, layout_.width, 3}](const Array<T, 2>& texels) {
      Array<T, 3> image(extents);
      std::copy_n(texels.data(), texels.size(), image.data());
      return image;
    };
    const auto everywhere = filled<T, 2>({layout_.height, layout_.width}, T(1));
    return record_scalar<T>(
        loss::smoothness(as_image(colours.value()), everywhere),
        [as_image, everywhere, values = colours.shared_value()](T adjoint, Array<T, 2>* colours_adjoint) {
          if (colours_adjoint == nullptr) return;
          Array<T, 3> image_adjoint = as_image(*colours_adjoint);
          loss::smoothness_adjoint(as_image(*values), everywhere, adjoint, image_adjoint);
          std::copy_n(image_adjoint.data(), image_adjoint.size(), colours_adjoint->data());
        },
        colours);
  }

  static Array<T, 1> joined(const std::vector<Array<T, 4>>& heads) {
    std::size_t size = 0;
    for (const auto& head : heads) size += head.size();
    Array<T, 1> all(Extents<1>{size});
    T* to = all.data();
    for (const auto& head : heads) to = std::copy_n(head.data(), head.size(), to);
    return all;
  }

  std::vector<Array<T, 4>> separated(const Array<T, 1>& all) const {
    std::vector<Array<T, 4>> heads;
    const T* from = all.data();
    for (const auto& head : pass_.logits) {
      heads.emplace_back(head.shape());
      std::copy_n(from, head.size(), heads.back().data());
      from += head.size();
    }
    return heads;
  }

  const detect::Network<T>& network_;
  raster::TextureLayout layout_;
  ObjectiveOptions options_;
  detect::Pass<T> pass_;
  ObjectiveTerms terms_;
  StepTimes times_;
};

}  // namespace tapestry::camouflage

#pragma once
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/detect/heat_map.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>
#include <tapestry/image/batch.hpp>

namespace tapestry::evaluate {
double best_confidence(const loss::Predictions<float>& predictions, const loss::Target& target,
                       double iou_threshold) {
  const auto best = detect::best_candidate(predictions.heads, predictions.logits, predictions.image,
                                           {target.class_index, target.box, iou_threshold},
                                           predictions.input_height, predictions.input_width);
  return best ? best->confidence : 0;
}

bool is_found(const std::vector<detect::Detection>& detections, const loss::Target& target,
              double iou_threshold) {
  return std::any_of(detections.begin(), detections.end(), [&](const detect::Detection& detection) {
    return detection.class_index == target.class_index &&
           detect::iou(detection.box, target.box) >= iou_threshold;
  });
}

namespace detail {
/// Colours of a paint in photographs of one draw.
inline Array<float, 2> photographed_colours(const camouflage::Paint<float>& paint,
                                            const Photography& photography, std::size_t draw) {
  if (!photography.conditions.has_print()) return paint.colours;
  return camouflage::printed(
      paint, image::draw_print(photography.conditions, Random(photography.seed).fork(2).fork(draw)));
}
}  // namespace detail

std::vector<Array<float, 2>> photographed_texels(const camouflage::View<float>& view,
                                                 const camouflage::Paint<float>& paint,
                                                 const Photography& photography) {
  std::vector<Array<float, 2>> texels(photography.conditions.has_print() ? photography.draws : 1);
  parallel_for(texels.size(), [&](std::size_t draw) {
    texels[draw] = camouflage::texels_of(view, detail::photographed_colours(paint, photography, draw));
  });
  return texels;
}

Photograph photograph_of_texels(const camouflage::View<float>& view, std::size_t view_index,
                                const Array<float, 2>* texels, const Photography& photography,
                                std::size_t draw) {
  Array<float, 3> picture =
      texels != nullptr ? camouflage::picture_of_texels(view, *texels) : view.background;
  detect::Box target = view.target;
  if (const image::Conditions& conditions = photography.conditions; conditions != image::Conditions{}) {
    const auto shot = camouflage::draw_shot(
        view, conditions, Random(photography.seed).fork(1).fork(draw).fork(view_index), false);
    picture = image::transformed(std::move(picture), shot.chain);
    target = shot.target;
  }
  return {std::move(picture), target};
}

Photograph photograph_of(const camouflage::View<float>& view, std::size_t view_index,
                         const camouflage::Paint<float>* paint, const Photography& photography,
                         std::size_t draw) {
  if (paint == nullptr) return photograph_of_texels(view, view_index, nullptr, photography, draw);
  const auto texels = camouflage::texels_of(view, detail::photographed_colours(*paint, photography, draw));
  return photograph_of_texels(view, view_index, &texels, photography, draw);
}

Effect effect_beyond(const Measurement& control, const Measurement& adversarial,
                     const BootstrapSettings& settings) {
  Effect effect{control.name,
                within(paired_bootstrap(
                           detail::means_of_views(control.best_confidence, control.draws),
                           detail::means_of_views(adversarial.best_confidence, adversarial.draws), settings),
                       1),
                rate_difference(control.found, adversarial.found, control.draws)};
  const auto found = [](const Measurement& measured) {
    const auto views = detail::means_of_views(measured.found, measured.draws);
    Array<double, 2> row(Extents<2>{1, views.size()});
    std::copy(views.begin(), views.end(), row.begin());
    return row;
  };
  effect.odds_ratio = odds_ratio(found(control), found(adversarial), control.draws, adversarial.draws);
  return effect;
}

ViewResult view_result(const std::vector<detect::Detection>& kept, double best_confidence,
                       const loss::Target& target, const std::vector<std::size_t>& related,
                       const MeterSettings& settings) {
  ViewResult result;
  const auto is_above = [&](const detect::Detection& one) { return one.confidence > settings.confidence; };
  result.detections.assign(kept.begin(), std::partition_point(kept.begin(), kept.end(), is_above));
  result.outcome = outcome_of(result.detections, target, related);
  const auto surest = std::ranges::find_if(kept, [&](const auto& one) { return is_found({one}, target); });
  if (surest != kept.end()) result.found_confidence = surest->confidence;
  result.found = result.found_confidence > settings.confidence;
  result.best_confidence = best_confidence;
  for (const auto& one : kept)
    if (one.class_index == target.class_index && one.confidence > ranked_confidence &&
        result.ranked.size() < most_ranked)
      result.ranked.push_back(
          {static_cast<float>(one.confidence), static_cast<float>(detect::iou(one.box, target.box))});
  return result;
}

ViewResult Meter::examine(const Array<float, 3>& picture, const std::string& name,
                          const detect::Box& target) {
  const auto pass = passes_.take();
  detector_.forward(image::batch_of(picture), *pass);
  const auto& logits = pass->logits;
  detect::require_finite_logits(logits, name);
  double least = settings_.confidence;
  for (const double threshold : settings_.sweep) least = std::min(least, threshold);
  const std::size_t height = detector_.input_height(), width = detector_.input_width();
  auto candidates =
      detect::decode(detector_.heads(), logits, 0, std::min(least, ranked_confidence), height, width);
  std::erase_if(candidates, [&](const auto& one) {  // suppression goes by class
    return one.confidence <= least && one.class_index != class_index_;
  });
  const auto kept =
      detect::suppress(std::move(candidates), settings_.nms, true, detector_.suppression_measure());
  const double best =
      best_confidence({detector_.heads(), loss::to_read(logits), 0, height, width}, {class_index_, target});
  return view_result(kept, best, {class_index_, target}, related_, settings_);
}

ProtocolTable physical_table(const PhysicalGrid& grid) {
  ProtocolTable table{"surroundings", {}, "distance", detail::short_numbers(grid.distances)};
  for (const char* as_it_is : {"", " as it is"})
    for (std::size_t place = 0; place < grid.surroundings; ++place)
      table.rows.push_back("street " + std::to_string(place + 1) + as_it_is);
  table.pictures_a_view.assign(grid.surroundings, grid.photographs);
  return table;
}

std::vector<ProtocolFrame> physical_frames(const PhysicalGrid& grid) {
  if (grid.photographs == 0) throw DomainError("physical_frames: no photographs of a view");
  const ViewGrid views{grid.distances, {grid.elevation_deg}, grid.azimuth_step_deg};
  std::vector<ProtocolFrame> frames;
  for (std::size_t place = 0; place < grid.surroundings; ++place)
    detail::for_each_view(
        "physical_frames", views, [&](std::size_t column, double distance, double elevation, double azimuth) {
          frames.insert(frames.end(), grid.photographs, {distance, elevation, azimuth, place, column});
          frames.push_back({distance, elevation, azimuth, grid.surroundings + place, column});
        });
  return frames;
}

PhysicalFrame physical_frame(const PhysicalGrid& grid, std::size_t frame) {
  const std::size_t view = frame / grid.frames_a_view(), picture = frame % grid.frames_a_view();
  const std::size_t views_a_place = grid.distances.size() * (360 / grid.azimuth_step_deg);
  PhysicalFrame shown{view, view / views_a_place};
  if (picture < grid.photographs) shown.photograph = picture;
  return shown;
}
}  // namespace tapestry::evaluate

#pragma once
#include "inputs.hpp"

namespace tapestry::shell {
inline evaluate::ProtocolPicture picture_of(const ProtocolRequest& request,
                                            const detect::Detector<float>& detector) {
  const auto& background = request.settings.background;
  return {detector.input_height(),
          detector.input_width(),
          request.scene.samples,
          detector.fit(),
          {background[0], background[1], background[2]}};
}

/// One view of the original car, and one of the reshaped car where there is one.
template <std::invocable<const raster::PaintedMesh&> ViewOf>
FrameViews views_of_shapes(const ProtocolInputs& inputs, ViewOf view_of) {
  FrameViews views{view_of(inputs.car.painted), std::nullopt};
  if (inputs.reshaped) views.reshaped = view_of(*inputs.reshaped);
  return views;
}

/// Numbers of photographs' views for Protocol::view_of: detectors that take pictures alike share them.
/// \param inputs  must outlive the result
inline std::function<std::size_t(std::size_t frame)> photograph_view(const ProtocolInputs& inputs) {
  return [&](std::size_t frame) {
    const auto& detectors = inputs.detectors;
    const std::size_t photograph = frame % inputs.photographs.size();
    const auto& own = detectors[frame / inputs.photographs.size()].detector;
    const auto first = std::ranges::find_if(detectors, [&](const FurtherDetector& other) {
      return other.detector.input_height() == own.input_height() &&
             other.detector.input_width() == own.input_width() && other.detector.fit() == own.fit();
    });
    return photograph * detectors.size() + static_cast<std::size_t>(first - detectors.begin());
  };
}

/// The source of the frames' views. A photograph or street is the same for both shapes of the car: its
/// camera, and its mask, which cuts off all beyond the original car.
inline std::function<FrameViews(std::size_t frame)> views_source(const Protocol& protocol,
                                                                 const ProtocolRequest& request,
                                                                 const ProtocolInputs& inputs) {
  const std::size_t samples = request.scene.samples;
  std::vector<std::optional<camouflage::PhotoLight>> lights;
  for (const auto& [detector, class_index] : inputs.detectors)
    lights.push_back(witnessed(inputs.photo_light, detector, class_index, request.detector));
  if (protocol.on_photographs)
    return [&, samples, lights](std::size_t frame) {
      const auto& detector = inputs.detectors[protocol.frames[frame].column].detector;
      const auto photograph =
          load_frame(inputs.photographs[frame % inputs.photographs.size()], inputs.mask, inputs.posed);
      return views_of_shapes(inputs, [&](const raster::PaintedMesh& car) {
        return camouflage::make_view<float>(photograph, car, detector.input_height(), detector.input_width(),
                                            samples, detector.fit(), lights[protocol.frames[frame].column],
                                            inputs.keeps_photograph && &car == &inputs.car.painted);
      });
    };
  const auto& detector = inputs.detectors.front().detector;
  const std::size_t height = detector.input_height(), width = detector.input_width();
  if (protocol.street)
    return [&, samples, height, width,
            vehicle = scenes::stand_on_ground(inputs.car.painted.mesh, inputs.car.painted.painted,
                                              street_car_length_m)](std::size_t frame) {
      auto street = protocol.street(vehicle, frame, std::max(height, width));
      street.camera = scenes::camera_of_mesh(vehicle, *street.camera);
      return views_of_shapes(inputs, [&](const raster::PaintedMesh& car) {
        constexpr bool keeps_photograph = false;  // the street may show no car
        return camouflage::make_view<float>(street, car, height, width, samples, detector.fit(), {},
                                            keeps_photograph);
      });
    };
  return [&](std::size_t frame) {
    return views_of_shapes(inputs, [&](const raster::PaintedMesh& car) {
      return evaluate::protocol_view(protocol.frames[frame], car, picture_of(request, detector));
    });
  };
}

/// A photograph as a detector takes it, or a render. All arguments must outlive the result.
inline ProtocolSource source_of(const Protocol& protocol, const ProtocolRequest& request,
                                const ProtocolInputs& inputs, std::vector<evaluate::Meter>& meters) {
  ProtocolSource source;
  source.views = views_source(protocol, request, inputs);
  const std::size_t period = protocol.on_photographs ? inputs.photographs.size() : protocol.frames.size();
  source.random = [=, random = Random(request.seed).fork(0x7069637475726573ULL)](std::size_t frame) {
    return random.fork(frame % period);  // whatever detectors there are
  };
  source.meter = [&](std::size_t frame) -> evaluate::Meter& {
    return meters[protocol.on_photographs ? protocol.frames[frame].column : 0];
  };
  if (protocol.maps_attention)
    source.attention = [&, heat_map = heat_map_by_name(request.settings.heat_map_kind)](
                           const auto& picture, const auto& view, std::size_t frame) {
      return attention_share(picture, view, inputs.detectors[protocol.frames[frame].column], heat_map);
    };
  return source;
}
}  // namespace tapestry::shell

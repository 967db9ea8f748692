#pragma once
#include "contact_sheet.hpp"
#include "inputs.hpp"
#include "picture_detections.hpp"
#include "program.hpp"
#include "progress.hpp"
#include "stop_signal.hpp"
#include "view_list.hpp"

namespace tapestry::shell {
/// States the length of a car that is not 1 to 30 m long, and the right --scale; else empty.
inline std::string word_on_size(const Car& car) {
  const double length = 2 * geometry::bounds_of(car.painted.mesh.positions).half_length();
  if ((length >= 1 && length <= 30) || !(length > 0)) return {};
  constexpr double inch = 0.0254, usual = 4.7;  // metres
  double scale = 1e6;
  for (const double unit : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, inch, 0.1, 10.0, 100.0, 1e3, 1e4, 1e5})
    if (std::abs(std::log(unit * length / usual)) < std::abs(std::log(scale * length / usual))) scale = unit;
  return "; the mesh is " + formatted("%.3g", length) + " long, and a car in metres 1 to 30: --scale " +
         formatted("%g", scale * car.scale) + " makes it " + formatted("%.3g", scale * length);
}

/// The error (mismatch) of frames without a visible car.
inline Error no_car_shown(const std::string& frames, const Car& car) {
  return Error(ErrorKind::mismatch, frames + ": no frame shows the car" + word_on_size(car));
}

/// The views of a store that show the car; every other view, and every one whose photograph does not hold it,
/// adds a warning.
/// \param mesh_path  for messages
/// \param is_measured  whether views without a light of their photograph are only measured, without an error
/// \throws Stopped when a signal arrives
/// \throws Error (mismatch) if no photograph holds the car where the light comes from them; if the car is too
///         small in all views for any detector, or, by its length, larger than all of them
inline std::vector<std::size_t> views_with_car(camouflage::ViewStore<float>& store,
                                               const std::string& mesh_path, const Car& car,
                                               std::vector<std::string>& warnings, bool is_measured = false) {
  constexpr double least_share = 2e-4;  // 6 x 6 pixels of 416 x 416
  double largest = 0, farthest = 0;
  std::size_t without = 0;
  const auto look_at = [&](const camouflage::View<float>& view) {
    StopSignal::throw_if_arrived();
    if (view.visible_pixels == 0) return;
    largest = std::max(largest, car_share_of(view) / (1 - std::min(view.hidden_share, 0.99)));
    farthest = std::max(farthest, view.orbit.distance);
    if (view.shows_car.value_or(true)) return;
    ++without;
    warnings.push_back("frame " + view.name +
                       " has no mask, and the detector finds no car where the mesh is: its photograph gives "
                       "no light and no pixels");
  };
  auto usable = camouflage::usable_views(store, look_at);
  warnings.insert(warnings.end(), usable.warnings.begin(), usable.warnings.end());
  const auto refuse = [&](const std::string& what) {
    print_warnings(warnings);
    throw Error(ErrorKind::mismatch, mesh_path + ": " + what + word_on_size(car));
  };
  const std::size_t count = usable.indices.size();
  if (count > 0 && largest < least_share)
    refuse("the car covers at most " + formatted("%.1g", largest) + " of a frame's picture");
  if (count > 0 && farthest < 1 && !word_on_size(car).empty()) refuse("the car lies around all cameras");
  if (!is_measured && count > 0 && without == count) {
    print_warnings(warnings);
    throw Error(ErrorKind::mismatch,
                "--light photo: no photograph shows the car to the detector; --light frame "
                "takes the light from elsewhere");
  }
  return std::move(usable.indices);
}

/// A detection as it is drawn, with its class and score.
/// \param is_car  whether it is the car where it should be
inline LabelledBox labelled_box(const detect::Detection& one, const std::vector<std::string>& names,
                                bool is_car) {
  return {one.box, label_of(class_name(one.class_index, names), one.confidence),
          is_car ? found_colour : class_colour(one.class_index)};
}

/// A picture in the photograph's own shape, without what a network's input has beside it, and its detections,
/// each with its class and score: in found_colour the car where it should be, others in the colours of their
/// classes.
inline MarkedPicture annotated(const evaluate::MeasuredPicture& measured, const evaluate::Meter& meter) {
  const auto& input = measured.picture;
  const auto& extents = measured.view.frame_extents;
  const auto kind = meter.detector().fit().kind;
  const auto place_by = [&](image::FitKind fit) {
    return image::placement(extents[0], extents[1], input.shape(0), input.shape(1), fit);
  };
  const auto place = place_by(kind);
  auto shown = image::crop(input, {place.top, place.left, place.height, place.width});
  if (kind == image::FitKind::stretch) {
    const auto own = place_by(image::FitKind::letterbox);
    shown = image::resize_bilinear(shown, own.height, own.width);
  }
  MarkedPicture marked{image::to_bytes(shown)};
  const auto from =
      image::picture_from_canvas(shown.shape(0), shown.shape(1), input.shape(0), input.shape(1), kind);
  const auto& names = meter.detector().names();
  for (const auto& one : measured.result.detections) {
    marked.boxes.push_back(labelled_box(one, names, meter.shows_car({one}, measured.target)));
    marked.boxes.back().box = {from.x(one.box.cx), from.y(one.box.cy), from.width(one.box.w),
                               from.height(one.box.h)};
  }
  return marked;
}

/// Follows a survey: prints its progress, keeps the annotated pictures of some textures, and throws Stopped
/// when a signal has arrived.
class SurveyWatch {
 public:
  /// \param pictures  number of pictures to come
  /// \param side      longer side of the pictures
  SurveyWatch(const evaluate::Meter& meter, std::size_t pictures, std::size_t side)
      : meter_(meter), progress_(pictures), side_(side) {}

  /// Adds the later pictures of a texture, `pictures` in number, to a sheet, which must outlive the watch; if
  /// they are more than `most`, or than a sheet holds, evenly spread ones.
  /// \returns the number of pictures on the sheet
  std::size_t collect(const std::string& texture, std::vector<MarkedPicture>& sheet, std::size_t pictures,
                      std::size_t most = std::numeric_limits<std::size_t>::max()) {
    most = std::min({pictures, most, most_on_a_sheet(side_)});
    sheets_.insert({texture, {&sheet, pictures, most, 0}});
    return most;
  }

  /// Facts of the views so far, in the order of the survey; one entry a picture.
  [[nodiscard]] const std::vector<ViewFacts>& views() const { return views_; }

  void operator()(const evaluate::MeasuredPicture& measured) {
    StopSignal::throw_if_arrived();
    if (measured.texture == "clean") views_.push_back(facts_of(measured.view));
    const auto [begin, end] = sheets_.equal_range(measured.texture);
    for (auto sheet = begin; sheet != end; ++sheet)
      if (sheet->second.takes_next()) sheet->second.sheet->push_back(annotated(measured, meter_));
    progress_.count(measured.texture);
  }

 private:
  struct Collected {
    std::vector<MarkedPicture>* sheet;
    std::size_t pictures;  ///< of the texture
    std::size_t most;      ///< of them on the sheet
    std::size_t seen;

    bool takes_next() { return is_shown(seen++, most, pictures); }
  };

  const evaluate::Meter& meter_;
  std::vector<ViewFacts> views_;
  MeasuringProgress progress_;
  std::size_t side_;
  std::multimap<std::string, Collected> sheets_;
};
}  // namespace tapestry::shell

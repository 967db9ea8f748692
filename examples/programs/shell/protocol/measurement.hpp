#pragma once
#include <tapestry/io/npy.hpp>
#include "../exported_pictures.hpp"
#include "../progress.hpp"
#include "../ranks.hpp"
#include "../stop_signal.hpp"
#include "protocol.hpp"

namespace tapestry::shell {
/// Calls visit(name, array) for each array of some outcomes.
template <class Outcomes, class Visit>
void for_each_array(Outcomes& outcomes, Visit visit) {
  visit("state", outcomes.state);
  visit("found", outcomes.found);
  visit("fate", outcomes.fate);
  visit("named", outcomes.named);
  visit("best_confidence", outcomes.best_confidence);
  visit("found_confidence", outcomes.found_confidence);
  visit("attention", outcomes.attention);
  visit("ranked", outcomes.ranked);
  visit("hidden_share", outcomes.hidden_share);
  visit("car_share", outcomes.car_share);
}

/// Reads saved outcomes.
/// \throws FileError: malformed (damaged, or with values that no measurement gives), mismatch (other extents)
inline evaluate::ProtocolOutcomes read_outcomes(const std::string& path, std::size_t frames,
                                                std::size_t textures) {
  const auto file = io::NpzFile::read(path);
  evaluate::ProtocolOutcomes outcomes(frames, textures);
  bool are_values = true;  // that a measurement has
  for_each_array(outcomes, [&]<class Values>(const char* name, Values& array) {
    constexpr std::size_t rank = std::tuple_size_v<typename Values::shape_type>;
    auto saved = file.array<typename Values::value_type, rank>(name);
    if (saved.shape() != array.shape())
      throw file_mismatch({path, "", "outcomes of another measurement",
                           std::to_string(frames) + " frames of " + std::to_string(textures) + " textures",
                           ""});
    array = std::move(saved);
    if constexpr (std::is_floating_point_v<typename Values::value_type>)
      are_values &=
          std::ranges::all_of(array.storage(), [](double share) { return share >= 0 && share <= 1; });
  });
  const auto at_most = [](std::uint8_t most) { return [=](std::uint8_t value) { return value <= most; }; };
  if (!are_values || !std::ranges::all_of(outcomes.state.storage(), at_most(2)) ||
      !std::ranges::all_of(outcomes.found.storage(), at_most(1)) ||
      !std::ranges::all_of(outcomes.fate.storage(), at_most(evaluate::fate_names.size() - 1)))
    throw malformed_file({path, "", "values that no measurement has"});
  return outcomes;
}

inline void set_result(evaluate::ProtocolOutcomes& outcomes, std::size_t frame, std::size_t column,
                       const evaluate::ViewResult& result) {
  outcomes.found(frame, column) = result.found ? 1 : 0;
  outcomes.fate(frame, column) = static_cast<std::uint8_t>(result.outcome.fate);
  outcomes.named(frame, column) = static_cast<std::uint16_t>(result.outcome.class_index);
  outcomes.best_confidence(frame, column) = result.best_confidence;
  outcomes.found_confidence(frame, column) = result.found_confidence;
  for (std::size_t i = 0; i < result.ranked.size(); ++i) {
    outcomes.ranked(frame, column, 2 * i) = result.ranked[i].confidence;
    outcomes.ranked(frame, column, 2 * i + 1) = result.ranked[i].iou;
  }
}

inline void write_outcomes(const std::string& path, const evaluate::ProtocolOutcomes& outcomes) {
  io::NpzWriter file;
  for_each_array(outcomes, [&](const char* name, const auto& array) { file.add(name, array); });
  file.write(path);
}

/// Views of one frame: of the original car, and of the car in the run's shape if the run has moved it.
struct FrameViews {
  camouflage::View<float> original;
  std::optional<camouflage::View<float>> reshaped{};

  [[nodiscard]] bool show_car() const {
    return original.visible_pixels > 0 && (!reshaped || reshaped->visible_pixels > 0);
  }
  /// The view to draw a texture in: the reshaped car for the camouflage and its controls, the original one
  /// for the clean texture and for unpainted pictures.
  /// \param textures  the clean one first; unpainted ones have no texels
  [[nodiscard]] const camouflage::View<float>& of(const std::vector<evaluate::Control>& textures,
                                                  std::size_t texture) const {
    const bool is_original = !reshaped || texture == 0 || textures[texture].paint.colours.size() == 0;
    return is_original ? original : *reshaped;
  }
};

/// Source of a protocol's frames, and the detectors that measure them.
struct ProtocolSource {
  std::function<FrameViews(std::size_t frame)> views;
  std::function<evaluate::Meter&(std::size_t frame)> meter;
  /// Random numbers of noise in a frame's pictures; frames that share a view share them.
  std::function<Random(std::size_t frame)> random;
  /// Share of the attention that lies on the car; empty where it is not measured.
  std::function<double(const Array<float, 3>& picture, const camouflage::View<float>&, std::size_t frame)>
      attention{};
  PictureExport* pictures = nullptr;  ///< writes every picture, which then has 8 bits a channel
};

/// A view's picture with a texture; for one without texels, only its background.
/// \param random  of noise that is drawn in the picture
inline Array<float, 3> picture_with(const camouflage::View<float>& view, const evaluate::Control& texture,
                                    const Random& random) {
  if (texture.name == evaluate::picture_noise_name)
    return evaluate::picture_with_noise(view, texture.paint, random);
  return texture.paint.colours.size() > 0 ? camouflage::picture_of(view, texture.paint.colours)
                                          : view.background;
}

/// Measures the frames of a protocol one after another, in one process the frames of one view together. Each
/// frame is measured with all textures, one a thread, and results are saved about once a second. Only one
/// frame's views and their pictures are in memory. With several ranks each takes the next frame, then all
/// exchange results, so that every rank has all outcomes, the same for any number of ranks.
class ProtocolMeasurement {
 public:
  /// \param textures  the clean one first. For one without texels the picture is only the background. They
  ///                  must outlive this object
  /// \param path      file to save outcomes in; empty: none
  ProtocolMeasurement(const Protocol& protocol, const std::vector<evaluate::Control>& textures,
                      std::string path, evaluate::ProtocolOutcomes outcomes)
      : protocol_(protocol), textures_(textures), path_(std::move(path)), outcomes_(std::move(outcomes)) {}

  /// Measures the frames that are not done yet.
  /// \throws Stopped after saving, when a signal has arrived at a rank; NumericError naming a frame
  void run(const ProtocolSource& source) {
    using evaluate::FrameState;
    const Ranks& ranks = Ranks::all();
    const auto start = Clock::now();
    Clock::time_point saved{};  // long ago: the first frame is saved at once
    std::vector<std::size_t> pending;
    for (std::size_t frame = 0; frame < protocol_.frames.size(); ++frame)
      if (outcomes_.state_of(frame) == FrameState::pending) pending.push_back(frame);
    if (ranks.count() == 1)  // several would make each view anew, and wait for the slowest detector
      std::ranges::stable_sort(pending, {}, [&](std::size_t frame) { return view_of(frame); });
    for (std::size_t first = 0; first < pending.size(); first += ranks.count()) {
      if (ranks.any(StopSignal::arrived())) {
        save();
        throw Stopped{};
      }
      const auto frames = std::span(pending).subspan(first, std::min(ranks.count(), pending.size() - first));
      if (ranks.index() < frames.size()) {
        const std::size_t frame = frames[ranks.index()];
        const bool is_measured = measure(frame, source);
        outcomes_.state(frame) =
            static_cast<std::uint8_t>(is_measured ? FrameState::measured : FrameState::left_out);
      }
      exchange(frames);
      frames_done_ += frames.size();
      show(seconds_since(start));
      if (seconds_since(saved) < 1) continue;
      save();
      saved = Clock::now();
    }
    save();
  }

  [[nodiscard]] const evaluate::ProtocolOutcomes& outcomes() const { return outcomes_; }
  /// Frames processed by this process and the other ranks.
  [[nodiscard]] std::size_t frames_done() const { return frames_done_; }
  [[nodiscard]] std::size_t frames_pending() const {
    return static_cast<std::size_t>(std::ranges::count(outcomes_.state.storage(), std::uint8_t{0}));
  }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] std::size_t view_of(std::size_t frame) const {
    return protocol_.view_of ? protocol_.view_of(frame) : frame;
  }
  /// Makes the views of a frame, unless they are the last ones. Keeps their pictures, too, if only
  /// the texture changes them.
  const FrameViews& views_of(std::size_t frame, const ProtocolSource& source) {
    const std::size_t number = view_of(frame);
    const bool is_last = views_ && view_number_ == number;
    if (!is_last) views_ = source.views(frame);
    if (!is_last || protocol_.change || protocol_.photograph)
      pictures_.assign(textures_.size(), std::nullopt);
    view_number_ = number;
    return *views_;
  }
  [[nodiscard]] evaluate::Photograph picture_of(std::size_t frame, const camouflage::View<float>& view,
                                                std::size_t texture, const ProtocolSource& source) const {
    if (protocol_.photograph) return protocol_.photograph(view, frame, textures_[texture].paint);
    return {picture_with(view, textures_[texture], source.random(frame)), view.target};
  }
  static double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  }

  /// The original car determines a frame's change and the car's share of the frame.
  bool measure(std::size_t frame, const ProtocolSource& source) {
    const FrameViews& views = views_of(frame, source);
    if (!views.show_car()) return false;
    std::optional<FrameChange> change;
    if (protocol_.change) {
      change = protocol_.change(views.original, frame);
      if (!change) return false;
      outcomes_.hidden_share(frame) = change->hidden_share;
    }
    outcomes_.car_share(frame) = car_share_of(views.original);
    auto& meter = source.meter(frame);
    std::vector<std::pair<Json, Json>> labels(source.pictures != nullptr ? textures_.size() : 0);
    parallel_for(textures_.size(), [&](std::size_t k) {
      const auto& view = views.of(textures_, k);
      if (!pictures_[k]) {
        pictures_[k] = picture_of(frame, view, k, source);
        if (change) change->apply(pictures_[k]->picture);
      }
      auto& [picture, target] = *pictures_[k];
      if (!labels.empty()) {
        picture = image::from_bytes<float>(image::to_bytes(picture));
        const Json facts{{"texture", textures_[k].name},
                         {"frame", frame},
                         {"column", k},
                         {"hidden_share", outcomes_.hidden_share(frame)},
                         {"car_share", outcomes_.car_share(frame)}};
        labels[k] = source.pictures->written(source.pictures->count() + 1 + k, picture, target, facts);
      }
      const auto result = meter.examine(picture, view.name, target);
      set_result(outcomes_, frame, k, result);
      if (source.attention) outcomes_.attention(frame, k) = source.attention(picture, view, frame);
    });
    for (auto& picture : labels) source.pictures->keep(std::move(picture));
    return true;
  }

  /// Gives every rank the results of a round; rank i has measured frames[i].
  void exchange(std::span<const std::size_t> frames) {
    const Ranks& ranks = Ranks::all();
    if (ranks.count() == 1) return;
    std::size_t width_of_all = 0;
    for_each_array(outcomes_,
                   [&](const char*, const auto& array) { width_of_all += array.size() / array.shape(0); });
    std::vector<double> row(width_of_all);
    const auto copy = [&](std::size_t frame, double* values, auto assign) {
      for_each_array(outcomes_, [&](const char*, auto& array) {
        const std::size_t width = array.size() / array.shape(0);
        for (std::size_t k = 0; k < width; ++k) assign(array.data()[frame * width + k], *values++);
      });
    };
    if (ranks.index() < frames.size())
      copy(frames[ranks.index()], row.data(),
           [](auto& own, double& value) { value = static_cast<double>(own); });
    auto rows = ranks.gathered(row);
    for (std::size_t rank = 0; rank < frames.size(); ++rank)
      copy(frames[rank], rows.data() + rank * row.size(), [](auto& own, double& value) {
        own = static_cast<std::remove_reference_t<decltype(own)>>(value);
      });
  }

  void show(double seconds) {
    const std::size_t left = frames_pending();
    const std::size_t done = protocol_.frames.size() - left;
    const double to_go = seconds / static_cast<double>(frames_done_) * static_cast<double>(left);
    progress_.show(
        protocol_.name + ": frame " + std::to_string(done) + " of " +
            std::to_string(protocol_.frames.size()) + ", each with " + std::to_string(textures_.size()) +
            (textures_.size() == 1 ? " texture, " : " textures, ") + duration_text(to_go) + " left",
        left == 0);
  }

  void save() const {
    if (!path_.empty()) write_outcomes(path_, outcomes_);
  }

  const Protocol& protocol_;
  const std::vector<evaluate::Control>& textures_;
  std::string path_;
  evaluate::ProtocolOutcomes outcomes_;
  std::size_t frames_done_ = 0;
  std::optional<FrameViews> views_{};
  std::size_t view_number_ = 0;                                  ///< of views_
  std::vector<std::optional<evaluate::Photograph>> pictures_{};  ///< of views_, with each texture
  ProgressLine progress_;
};
}  // namespace tapestry::shell

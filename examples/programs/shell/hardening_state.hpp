#pragma once
#include <tapestry/camouflage/training.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/image/batch.hpp>
#include "../../scenes/labelled_scene.hpp"
#include "../../scenes/paint.hpp"
#include "checkpoint_file.hpp"
#include "learner.hpp"
#include "stop_signal.hpp"

namespace tapestry::shell {
/// Objects in each training view: the car, whose box is known, and the other objects that the undefended
/// detector finds in the untouched frame away from the car. A frame has no labels for other objects; treating
/// them as background would train the detector to miss them.
///
/// \param usable      views of the store that show the car
/// \param confidence least confidence of a detection that counts
/// \returns one entry a view of `usable`
inline loss::Truths view_truths(const detect::Detector<float>& undefended, std::size_t class_index,
                                camouflage::ViewStore<float>& store, const std::vector<std::size_t>& usable,
                                double confidence, double nms) {
  loss::Truths truths;
  detect::Pass<float> pass;
  for (const std::size_t index : usable) {
    StopSignal::throw_if_arrived();
    const auto view = store.view(index);
    undefended.forward(image::batch_of(view->background), pass);
    auto& of_view = truths.emplace_back();
    of_view.push_back({class_index, view->target});
    for (const auto& found : undefended.detections(pass.logits, 0, confidence, nms)) {
      const bool is_inside = found.box.cx > 0 && found.box.cy > 0 &&
                             found.box.cx < static_cast<double>(undefended.input_width()) &&
                             found.box.cy < static_cast<double>(undefended.input_height());
      if (is_inside && detect::iou(found.box, view->target) < 0.3)
        of_view.push_back({found.class_index, found.box});
    }
  }
  return truths;
}

/// Paints to train against, and noise made from them.
struct PaintPool {
  bool is_ordinary = false;             ///< whether cars wear plain colours instead, as cars in streets do
  std::vector<Array<float, 2>> paints;  ///< of finished rounds, [texel, 3]
  std::vector<Array<float, 2>> noises;  ///< matched noise and shuffled patches of each

  void add(const raster::PaintedMesh& car, Array<float, 2> colours, std::uint64_t seed) {
    for (auto& control : evaluate::matched_controls(car, {colours}, seed + paints.size()))
      noises.push_back(std::move(control.paint.colours));
    paints.push_back(std::move(colours));
  }
};

/// Draws the paint of a training picture. Half of them show the round's own paint, a quarter earlier rounds'
/// paints, and a quarter paints that were not optimised: matched noise, shuffled patches, random noise, solid
/// colours. Otherwise the detector would learn one paint only. In an ordinary pool: the colour of a car.
inline Array<float, 2> draw_paint(Random& random, const Array<float, 2>& current, const PaintPool& pool) {
  const std::size_t texels = current.shape(0);
  if (pool.is_ordinary) {
    const auto colour = scenes::car_colour(random);
    return camouflage::solid_colours<float>(
        texels,
        {static_cast<double>(colour[0]), static_cast<double>(colour[1]), static_cast<double>(colour[2])});
  }
  const double kind = random.uniform();
  if (kind < 0.5 || (kind < 0.75 && pool.paints.empty())) return current;
  if (kind < 0.75) return pool.paints[random.index(pool.paints.size())];
  if (kind < 0.9 && !pool.noises.empty()) return pool.noises[random.index(pool.noises.size())];
  if (random.chance(0.5)) return camouflage::random_colours<float>(texels, random);
  const std::array<double, 3> colour{random.uniform(0.02, 0.98), random.uniform(0.02, 0.98),
                                     random.uniform(0.02, 0.98)};
  return camouflage::solid_colours<float>(texels, colour);
}

struct CleanSource {
  std::vector<scenes::LabelledScene> scenes;  ///< drawn ones with labels; may be empty
  Array<float, 2> own_colours;                ///< of the car, [texel, 3]
  loss::Truths truths;                        ///< one entry a usable view
};

/// Makes the pictures that one step of the weights learns from. They depend only on `random`, the paints and
/// the views, for any number of threads.
class MixedBatch {
 public:
  /// \param store must outlive the batch, like the other arguments
  MixedBatch(camouflage::ViewStore<float>& store, const std::vector<std::size_t>& usable,
             const CleanSource& clean, std::size_t count, double painted)
      : store_(store),
        usable_(usable),
        clean_(clean),
        painted_(static_cast<std::size_t>(painted * static_cast<double>(count) + 0.5)),
        images_(Extents<4>{count, store.settings().height, store.settings().width, 3}) {}

  void fill(Random random, const Array<float, 2>& current, const PaintPool& pool) {
    truths_.assign(images_.shape(0), {});
    std::vector<Part> parts;
    for (std::size_t image = 0; image < images_.shape(0); ++image)
      parts.push_back(image < painted_ ? painted_part(random, current, pool) : clean_part(random));
    parallel_for(parts.size(), [&](std::size_t image) { write(parts[image], image); });
  }

  [[nodiscard]] const Array<float, 4>& images() const { return images_; }
  [[nodiscard]] const loss::Truths& truths() const { return truths_; }

 private:
  /// One picture: a drawn scene, or a view with colours, or an untouched view.
  struct Part {
    const scenes::LabelledScene* scene = nullptr;
    std::shared_ptr<const camouflage::View<float>> view;
    Array<float, 2> colours;
    bool is_photo = false;
    std::size_t place = 0;  ///< index of the view among the usable ones
    scenes::Variation variation;
  };

  [[nodiscard]] Part view_part(Random& random) const {
    Part part;
    part.place = random.index(usable_.size());
    part.view = store_.view(usable_[part.place]);
    return part;
  }

  [[nodiscard]] Part painted_part(Random& random, const Array<float, 2>& current,
                                  const PaintPool& pool) const {
    Part part = view_part(random);
    part.colours = draw_paint(random, current, pool);
    part.variation = scenes::draw_variation(random);
    return part;
  }

  /// Half of the clean pictures are drawn scenes, if there are any. A quarter each are untouched frames and
  /// renders of the car in its own colours.
  [[nodiscard]] Part clean_part(Random& random) const {
    Part part;
    if (!clean_.scenes.empty() && random.chance(0.5)) {
      part.scene = &clean_.scenes[random.index(clean_.scenes.size())];
    } else {
      part = view_part(random);
      part.is_photo = random.chance(0.5);
      if (!part.is_photo) part.colours = clean_.own_colours;
    }
    part.variation = scenes::draw_variation(random);
    return part;
  }

  void write(const Part& part, std::size_t image) {
    const auto& truths = part.scene != nullptr ? part.scene->truths : clean_.truths[part.place];
    truths_[image] = scenes::varied(truths, part.variation, images_.shape(2));
    if (part.scene != nullptr)
      return scenes::put_into_batch(part.scene->colours, image, part.variation, images_);
    const Array<float, 3> picture =
        part.is_photo ? part.view->background : camouflage::picture_of(*part.view, part.colours);
    scenes::put_into_batch(picture, image, part.variation, images_);
  }

  camouflage::ViewStore<float>& store_;
  const std::vector<std::size_t>& usable_;
  const CleanSource& clean_;
  std::size_t painted_;
  Array<float, 4> images_;
  loss::Truths truths_;
};

/// One step of the weights, as history.csv lists it: terms of the training loss, and the last loss of the
/// round's paint.
struct HardeningStep : LossTerms {
  double attack = 0;
  static const std::array<StepNumber<HardeningStep>, 5> all;
};
inline constexpr std::array<StepNumber<HardeningStep>, 5> HardeningStep::all{
    {{"box", &HardeningStep::box},
     {"objectness", &HardeningStep::objectness},
     {"classification", &HardeningStep::classification},
     {"total", &HardeningStep::total},
     {"attack", &HardeningStep::attack}}};

/// Everything that changes while a detector is hardened. Two runs with equal states and settings continue
/// with the same bits.
struct HardeningState {
  std::uint64_t done = 0;               ///< steps of all rounds, with steps of the paint alone
  Array<float, 1> parameters;           ///< of the detector
  optim::AdamState<float> adam;         ///< of the detector's parameters
  Array<float, 2> paint;                ///< the round's texture parameter, [texel, 3]
  optim::AdamState<float> attack;       ///< of the paint
  std::vector<Array<float, 2>> paints;  ///< colours of finished rounds
  std::vector<HardeningStep> history;   ///< one entry a step of the weights
};

/// Writes the checkpoint; the previous one survives any interruption.
/// \param identity  of the run, see identity_text()
inline void write_hardening(const std::string& path, const HardeningState& state,
                            const std::string& identity) {
  Array<float, 3> paints(Extents<3>{state.paints.size(), state.paint.shape(0), 3});
  for (std::size_t i = 0; i < state.paints.size(); ++i)
    std::copy_n(state.paints[i].data(), state.paint.size(), paints.data() + i * state.paint.size());
  io::NpzWriter file = begun_checkpoint(identity);
  file.add("done", state.done);
  file.add("parameters", state.parameters);
  detail::add_adam(file, "adam", state.adam);
  file.add("paint", state.paint);
  detail::add_adam(file, "attack", state.attack);
  file.add("paints", paints);
  file.add("history", detail::rows_of(state.history));
  file.write(path);
}

/// \param fresh  initial state; the checkpoint must have its extents
/// \throws FileError: malformed (damaged, or numbers that no training reaches), mismatch (a newer format, or
///         other extents); Error (in_use) for the checkpoint of a run with other settings
inline HardeningState read_hardening(const std::string& path, const std::string& identity,
                                     const HardeningState& fresh) {
  const auto file = read_checkpoint_file(path, identity);
  HardeningState state = fresh;
  state.done = detail::number_of(file, "done");
  state.parameters = detail::weights_of(file, "parameters", fresh.parameters);
  state.adam = detail::adam_of(file, "adam", fresh.parameters.size());
  const auto paint = detail::finite_values(file, "paint", fresh.paint.size());
  std::copy(paint.begin(), paint.end(), state.paint.data());
  state.attack = detail::adam_of(file, "attack", fresh.paint.size());
  const auto paints = file.array<float, 3>("paints");
  detail::require_size(path, "paints", paints.shape(0) * fresh.paint.size(), paints.size());
  for (std::size_t i = 0; i < paints.shape(0); ++i) {
    state.paints.push_back(fresh.paint);
    std::copy_n(paints.data() + i * fresh.paint.size(), fresh.paint.size(), state.paints.back().data());
  }
  state.history = detail::history_of<HardeningStep>(file);
  return state;
}
}  // namespace tapestry::shell

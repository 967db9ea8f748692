#include <tapestry/camouflage/training.hpp>

#include "bindings.hpp"

namespace tapestry::python {
namespace {
using Detector = detect::Detector<float>;
using FramePointer = std::shared_ptr<io::Frame>;

/// One step of Adam, in the caller's own array.
void step(optim::Adam<float>& adam, py::array_t<float, py::array::c_style>& parameters,
          const py::array_t<float, py::array::c_style | py::array::forcecast>& gradient) {
  const auto count = [](const py::array& array) { return static_cast<std::size_t>(array.size()); };
  const std::span<float> values(parameters.mutable_data(), count(parameters));
  const std::span<const float> slopes(gradient.data(), count(gradient));
  released([&] { adam.step(values, slopes); });
}

/// A run: objects that stay in place while the paint is optimised.
class Session {
 public:
  Session(const Detector& detector, const Mesh& mesh, const std::vector<FramePointer>& frames,
          const camouflage::ObjectiveOptions& objective, const camouflage::TrainingOptions& options,
          std::size_t samples, const py::object& start)
      : store_(mesh, {detector.input_height(), detector.input_width(), samples, keep_bytes, detector.fit()},
               loaders_of(mesh, frames)),
        objective_(detector, objective) {
    auto parameter = start.is_none() ? zeros<float, 2>({mesh.texel_count(), 3})
                                     : camouflage::parameter_of_colours(colours_of<2>("start", start));
    require_shape("camouflage", "start", parameter, {mesh.texel_count(), 3});
    const auto usable = released([&] { return camouflage::usable_views(store_); });
    warn(usable.warnings);
    if (usable.indices.empty()) throw DomainError("camouflage: no frame shows the mesh");
    training_.emplace(objective_, store_, usable.indices, std::move(parameter), options);
  }

  /// Calls back after each step; a true value or an exception of Python ends the run.
  void run(const py::object& callback) {
    while (!training_->finished()) {
      released([&] { training_->step(); });
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (callback.is_none()) continue;
      if (py::bool_(callback(training_->steps_taken(), dict_of(training_->history().back())))) return;
    }
  }

  [[nodiscard]] py::tuple result() const {
    py::list history;
    for (const auto& terms : training_->history()) history.append(dict_of(terms));
    return py::make_tuple(handed_over(camouflage::texture_colours(training_->parameter())), history);
  }

 private:
  static constexpr std::size_t keep_bytes = std::size_t(4) << 30U;

  static std::vector<camouflage::ViewStore<float>::Loader> loaders_of(
      const Mesh& mesh, const std::vector<FramePointer>& frames) {
    std::vector<camouflage::ViewStore<float>::Loader> loaders;
    for (const auto& frame : frames) {
      mesh.require_seen_by(*frame);
      loaders.emplace_back([frame] { return *frame; });
    }
    return loaders;
  }

  camouflage::ViewStore<float> store_;
  camouflage::Objective<float> objective_;
  std::optional<camouflage::Training<float>> training_{};
};

py::tuple optimised(const Detector& detector, const Mesh& mesh, const std::vector<FramePointer>& frames,
                    const std::string& class_name, const std::string& loss, double smoothness,
                    std::size_t epochs, std::size_t batch, double learning_rate, std::uint64_t seed,
                    std::size_t samples, const py::object& start, const py::object& callback) {
  if (batch == 0 || !(learning_rate > 0) || !(smoothness >= 0))
    throw DomainError("camouflage: batch and learning_rate must be above 0, smoothness at least 0");
  Session session(detector, mesh, frames,
                  {.kind = loss::adversarial_loss_by_name(loss),
                   .smoothness = smoothness,
                   .printability = 0,
                   .class_index = detector.class_index(class_name)},
                  {.epochs = epochs, .batch = batch, .seed = seed, .adam = {.learning_rate = learning_rate}},
                  samples, start);
  session.run(callback);
  return session.result();
}

py::tuple composite(const FramePointer& frame, const Mesh& mesh, const py::object& colours,
                    const Detector& detector, std::size_t samples) {
  mesh.require_seen_by(*frame);
  const auto paint = colours_of<2>("colours", colours);
  require_shape("composite", "colours", paint, {mesh.texel_count(), 3});
  auto [picture, box] = released([&] {
    const auto view = camouflage::make_view<float>(*frame, mesh, detector.input_height(),
                                                   detector.input_width(), samples, detector.fit());
    return std::pair(camouflage::picture_of(view, paint), view.target);
  });
  return py::make_tuple(handed_over(std::move(picture)),
                        handed_over(Array<double, 1>{box.left(), box.top(), box.right(), box.bottom()}));
}
}  // namespace

void add_camouflage(py::module_& module) {
  using py::arg;
  py::class_<optim::Adam<float>>(module, "Adam",
                                 "The optimiser Adam for count parameters. See Kingma and Ba, ICLR 2015.")
      .def(py::init([](std::size_t count, double learning_rate, double beta1, double beta2, double epsilon) {
             return optim::Adam<float>(count, {learning_rate, beta1, beta2, epsilon});
           }),
           arg("count"), arg("learning_rate") = 0.01, arg("beta1") = 0.9, arg("beta2") = 0.999,
           arg("epsilon") = 1e-8)
      .def("step", &step, arg("parameters").noconvert(), arg("gradient"),
           "Changes parameters, a contiguous float32 array of any extents, in place by one step against the "
           "gradient, of as many numbers.");
  module.def(
      "camouflage", &optimised, arg("detector"), arg("mesh"), arg("frames"), arg("class_name") = "car",
      arg("loss") = "max_score", arg("smoothness") = 1, arg("epochs") = 5, arg("batch") = 8,
      arg("learning_rate") = 0.1, arg("seed") = 1, arg("samples") = 2, arg("start") = py::none(),
      arg("callback") = py::none(),
      "Optimises a texture so that the detector loses the mesh in the frames, as the program camouflage "
      "does: "
      "colours [T, 3] in [0, 1], and the loss's terms of every step. start: colours [T, 3], None for mid "
      "grey. "
      "callback(step, terms) is called after each step; a true value ends the run.");
  module.def("composite", &composite, arg("frame"), arg("mesh"), arg("colours"), arg("detector"),
             arg("samples") = 2,
             "The mesh in a texture [T, 3] laid over the frame's photograph, as the detector takes it, "
             "[height, width, 3], "
             "and the box around what shows of it: left, top, right, bottom in pixels.");
}
}  // namespace tapestry::python

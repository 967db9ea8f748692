#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/io/read_detector.hpp>

#include "bindings.hpp"

namespace tapestry::python {
namespace {
using Detector = detect::Detector<float>;

/// Rows of left, top, right, bottom, score and class.
py::array_t<float> rows_of(const std::vector<detect::Detection>& found) {
  Array<float, 2> rows(Extents<2>{found.size(), 6});
  float* row = rows.data();
  for (const auto& [class_index, confidence, objectness, box, head, candidate] : found)
    for (const double value :
         {box.left(), box.top(), box.right(), box.bottom(), confidence, static_cast<double>(class_index)})
      *row++ = static_cast<float>(value);
  return handed_over(std::move(rows));
}

/// One forward pass: its logits, and the pullback from them to the pictures.
class Run {
 public:
  Run(std::shared_ptr<const Detector> detector, const Array<float, 4>& pictures)
      : detector_(std::move(detector)), shape_(pictures.shape()) {
    detector_->forward(pictures, pass_, detect::Mode::input_gradient);
  }

  static std::vector<py::array_t<float>> logits(const py::object& self) {
    std::vector<py::array_t<float>> all;
    for (const auto& logits : self.cast<const Run&>().pass_.logits) all.push_back(shown(logits, self));
    return all;
  }

  [[nodiscard]] std::vector<py::array_t<float>> boxes(double confidence, double overlap) const {
    std::vector<py::array_t<float>> all;
    for (std::size_t n = 0; n < pass_.images; ++n)
      all.push_back(rows_of(detector_->detections(pass_.logits, n, confidence, overlap)));
    return all;
  }

  py::array_t<float> pull_back(const std::vector<py::object>& adjoints) {
    std::vector<Array<float, 4>> arrays(adjoints.size());
    std::vector<const Array<float, 4>*> pointers(adjoints.size());
    for (std::size_t i = 0; i < adjoints.size(); ++i) {
      if (adjoints[i].is_none()) continue;
      arrays[i] = numbers_of<4>("an adjoint of logits", adjoints[i]);
      pointers[i] = &arrays[i];
    }
    auto gradient = zeros<float, 4>(shape_);
    released([&] { detector_->pull_back(pass_, pointers, &gradient); });
    return handed_over(std::move(gradient));
  }

 private:
  std::shared_ptr<const Detector> detector_;
  Extents<4> shape_;
  detect::Pass<float> pass_{};
};

std::shared_ptr<Detector> load(const std::string& weights, const std::string& config,
                               const std::string& description, const std::string& names, std::size_t size) {
  std::vector<std::string> warnings;
  auto detector = released([&] {
    return std::make_shared<Detector>(io::read_detector<float>(
        {.weights = weights, .config = config, .names = names, .description = description, .size = size},
        &warnings));
  });
  warn(warnings);
  return detector;
}

std::unique_ptr<Run> forward(std::shared_ptr<Detector> detector, const py::object& pictures) {
  const auto batch = colours_of<4>("pictures", pictures);
  return released([&] { return std::make_unique<Run>(std::move(detector), batch); });
}

py::array_t<float> detected(const Detector& detector, const py::object& photograph, double confidence,
                            double overlap) {
  const auto picture = colours_of<3>("a photograph", photograph);
  return rows_of(released([&] {
    detect::Pass<float> pass;
    detector.forward(detector.input(picture), pass);
    return detector.in_photograph(detector.detections(pass.logits, 0, confidence, overlap), picture.shape(0),
                                  picture.shape(1));
  }));
}

py::tuple adversarial(const Detector& detector, const std::vector<py::object>& logits,
                      const py::object& targets, const std::string& loss) {
  std::vector<Array<float, 4>> values;
  for (const auto& head : logits) values.push_back(numbers_of<4>("logits", head));
  const auto rows = numbers_of<2>("targets", targets);
  if (rows.shape(1) != 5) throw ShapeError({"targets are ", rows.shape(), ", expected 5 columns"});
  std::vector<loss::Target> hidden;
  for (const float* row = rows.data(); row != rows.data() + rows.size(); row += 5) {
    if (!(row[4] >= 0 && row[4] < 1e6F)) throw DomainError({"targets hold the class ", row[4]});
    hidden.push_back({static_cast<std::size_t>(row[4]), box_of(row)});
  }
  const auto kind = loss::adversarial_loss_by_name(loss);
  const auto terms = released([&] {
    Tape<float> tape;
    const auto scope = tape.activate();
    std::vector<ArrayVariable<float, 4>> inputs;
    for (const auto& head : values) inputs.push_back(tape.input(head));
    const auto found = loss::adversarial(detector, inputs, hidden, kind);
    tape.reverse(found.total);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = inputs[i].adjoint();
    return camouflage::numbers_of(found);
  });
  py::list adjoints;
  for (auto& head : values) adjoints.append(handed_over(std::move(head)));
  return py::make_tuple(dict_of(terms), adjoints);
}

void add_run(py::module_& module) {
  using py::arg;
  py::class_<Run>(module, "Run", "One forward pass, which keeps what its gradient needs.")
      .def_property_readonly("logits", &Run::logits,
                             "Raw numbers of each head, [N, channels, rows, columns], read-only.")
      .def("boxes", &Run::boxes, arg("confidence") = 0.25, arg("overlap") = 0.45,
           "Objects of each picture, [count, 6]: left, top, right, bottom in pixels, score, class.")
      .def("pull_back", &Run::pull_back, arg("adjoints"),
           "Gradient by the pictures, [N, height, width, 3], from a list of adjoints of the logits, each of "
           "the extents of its head; None stands for zeros.");
}
}  // namespace

void add_detector(py::module_& module) {
  using py::arg;
  add_run(module);
  module.def(
      "iou",
      [](const py::object& box, const py::object& other) {
        const auto a = numbers_of<1>("box", box), b = numbers_of<1>("other", other);
        if (std::min(a.size(), b.size()) < 4) throw ShapeError("a box has less than 4 numbers");
        return detect::iou(box_of(a.data()), box_of(b.data()));
      },
      arg("box"), arg("other"), "Intersection over union of two boxes: left, top, right, bottom, and more.");
  py::class_<Detector, std::shared_ptr<Detector>>(
      module, "Detector",
      "A detector from an ONNX model, or from Darknet weights with their cfg as config. description names a "
      "family of exports or its JSON file, names a file of classes, size the side of the input in pixels.")
      .def(py::init(&load), arg("weights"), arg("config") = "", arg("description") = "", arg("names") = "",
           arg("size") = 0)
      .def_property_readonly("height", &Detector::input_height, "Rows of the input.")
      .def_property_readonly("width", &Detector::input_width, "Columns of the input.")
      .def_property_readonly("names", &Detector::names, "Names of the classes, in their order; may be empty.")
      .def("class_index", &Detector::class_index, arg("name"),
           "Number of the class of that name, or of that number as text.")
      .def(
          "detect", &detected, arg("photograph"), arg("confidence") = 0.25, arg("overlap") = 0.45,
          "Objects of a photograph [h, w, 3] of any size, surest first, [count, 6]: left, top, right, bottom "
          "in pixels of the photograph, score, class.")
      .def(
          "fitted",
          [](const Detector& detector, const py::object& photograph) {
            return handed_over(detector.input(colours_of<3>("a photograph", photograph)));
          },
          arg("photograph"),
          "A photograph [h, w, 3] of any size as a batch [1, height, width, 3] for forward.")
      .def("forward", &forward, arg("pictures"),
           "A pass over pictures [N, height, width, 3]: bytes, or floating-point RGB in [0, 1].")
      .def("adversarial", &adversarial, arg("logits"), arg("targets"), arg("loss") = "paper",
           "The loss that hides targets [N, 5], one a picture: left, top, right, bottom in pixels of the "
           "input, class. By name: paper, as_coded, max_score or vanish. Its terms, means over the pictures, "
           "and their total's gradient by the logits, a list of arrays as Run.pull_back takes them.");
}
}  // namespace tapestry::python

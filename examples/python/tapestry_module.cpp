// The Python module `tapestry`: detectors and a textured mesh as functions of NumPy arrays, each with the
// product of its transposed Jacobian, which is what a training framework calls backward. See
// torch_functions.py.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/painted.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace py = pybind11;
using namespace tapestry;

namespace {
using Numbers = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// \throws ShapeError unless the array has so many axes
template <std::size_t Rank>
Array<float, Rank> array_of(const char* name, const Numbers& numbers) {
  if (numbers.ndim() != static_cast<py::ssize_t>(Rank))
    throw ShapeError({name, " has ", numbers.ndim(), " axes, expected ", Rank});
  Extents<Rank> shape{};
  for (std::size_t axis = 0; axis < Rank; ++axis)
    shape[axis] = static_cast<std::size_t>(numbers.shape(static_cast<py::ssize_t>(axis)));
  Array<float, Rank> array(shape);
  std::copy_n(numbers.data(), array.size(), array.data());
  return array;
}

/// Colours, RGB in [0, 1], of a NumPy array or lists.
/// \param unchecked  takes any numbers
/// \throws DomainError for bytes and other integers, NaN, infinities, and colours far outside of the range
template <std::size_t Rank>
Array<float, Rank> colours_of(const char* name, const py::object& colours, bool unchecked) {
  constexpr const char* expected =
      ", expected floating-point RGB in [0, 1]; unchecked=True takes any numbers";
  const auto given = py::array::ensure(colours);
  if (!given) throw DomainError({name, " is no array", expected});
  if (!unchecked && given.dtype().kind() != 'f')
    throw DomainError({name, " holds ", py::str(given.dtype()).cast<std::string>(), expected});
  auto array = array_of<Rank>(name, Numbers::ensure(given));
  for (const float value : array)
    if (!unchecked && !(value >= -1 && value <= 2)) throw DomainError({name, " holds ", value, expected});
  return array;
}

template <std::size_t Rank>
Numbers numbers_of(const Array<float, Rank>& array) {
  std::vector<py::ssize_t> shape;
  for (const std::size_t extent : array.shape()) shape.push_back(static_cast<py::ssize_t>(extent));
  Numbers numbers(shape);
  std::copy_n(array.data(), array.size(), numbers.mutable_data());
  return numbers;
}

using Detector = detect::Detector<float>;

/// One forward pass: its logits, and the pullback from them to the pictures.
class Run {
 public:
  Run(std::shared_ptr<const Detector> detector, const Array<float, 4>& pictures)
      : detector_(std::move(detector)), shape_(pictures.shape()) {
    detector_->forward(pictures, pass_, detect::Mode::input_gradient);
  }

  [[nodiscard]] std::vector<Numbers> logits() const {
    std::vector<Numbers> all;
    for (const auto& logits : pass_.logits) all.push_back(numbers_of(logits));
    return all;
  }

  /// Rows of left, top, right, bottom in pixels of the input, score and class, for each picture.
  [[nodiscard]] std::vector<Numbers> boxes(double confidence, double overlap) const {
    std::vector<Numbers> all;
    for (std::size_t n = 0; n < pass_.images; ++n) {
      const auto found = detector_->detections(pass_.logits, n, confidence, overlap);
      Array<float, 2> rows(Extents<2>{found.size(), 6});
      for (std::size_t i = 0; i < found.size(); ++i) {
        const detect::Box& box = found[i].box;
        const std::array<double, 6> row{box.cx - box.w / 2,  box.cy - box.h / 2,
                                        box.cx + box.w / 2,  box.cy + box.h / 2,
                                        found[i].confidence, double(found[i].class_index)};
        std::ranges::transform(row, rows.data() + 6 * i,
                               [](double value) { return static_cast<float>(value); });
      }
      all.push_back(numbers_of(rows));
    }
    return all;
  }

  Numbers pull_back(const std::vector<std::optional<Numbers>>& adjoints) {
    std::vector<Array<float, 4>> arrays;
    for (const auto& adjoint : adjoints)
      arrays.push_back(adjoint ? array_of<4>("an adjoint of logits", *adjoint) : Array<float, 4>());
    std::vector<const Array<float, 4>*> pointers;
    for (std::size_t i = 0; i < arrays.size(); ++i) pointers.push_back(adjoints[i] ? &arrays[i] : nullptr);
    auto gradient = zeros<float, 4>(shape_);
    {
      const py::gil_scoped_release others_may_run;
      detector_->pull_back(pass_, pointers, &gradient);
    }
    return numbers_of(gradient);
  }

 private:
  std::shared_ptr<const Detector> detector_;
  Extents<4> shape_;
  detect::Pass<float> pass_{};
};

/// A mesh seen by a camera: the linear map from the texels of its atlas to a picture.
class View {
 public:
  View(const std::string& mesh, const std::string& material, std::size_t rows, double azimuth,
       double elevation, double distance, double field_of_view, std::size_t size) {
    const auto body = raster::painted(
        io::read_obj(mesh).mesh, {.material = material, .rows = rows, .space = image::ColourSpace::encoded});
    const auto camera = geometry::orbit_camera(azimuth, elevation, distance, {0, 0, 0}, field_of_view);
    operator_ = raster::texture_operator<float>(body, camera, size, size, raster::Light{});
  }

  [[nodiscard]] std::size_t texel_count() const { return operator_.texel_count; }
  [[nodiscard]] Numbers coverage() const { return numbers_of(operator_.coverage); }

  [[nodiscard]] Numbers render(const py::object& texels, bool unchecked) const {
    const auto colours = colours_of<2>("texels", texels, unchecked);
    Array<float, 3> picture;
    {
      const py::gil_scoped_release others_may_run;
      picture = raster::render(operator_, colours);
    }
    return numbers_of(picture);
  }

  [[nodiscard]] Numbers pull_back(const Numbers& picture_adjoint) const {
    const auto adjoint = array_of<3>("the picture's adjoint", picture_adjoint);
    auto gradient = zeros<float, 2>({operator_.texel_count, 3});
    {
      const py::gil_scoped_release others_may_run;
      raster::render_adjoint(operator_, adjoint, gradient);
    }
    return numbers_of(gradient);
  }

 private:
  raster::TextureOperator<float> operator_;
};

void add_detector(py::module_& module) {
  py::class_<Detector, std::shared_ptr<Detector>>(module, "Detector")
      .def(py::init([](const std::string& weights, const std::string& config, const std::string& description,
                       const std::string& names, std::size_t size) {
             const py::gil_scoped_release others_may_run;
             return std::make_shared<Detector>(io::read_detector<float>({.weights = weights,
                                                                         .config = config,
                                                                         .names = names,
                                                                         .description = description,
                                                                         .size = size}));
           }),
           py::arg("weights"), py::arg("config") = "", py::arg("description") = "", py::arg("names") = "",
           py::arg("size") = 0, "An ONNX model, or Darknet weights with their cfg as config.")
      .def_property_readonly("height", &Detector::input_height)
      .def_property_readonly("width", &Detector::input_width)
      .def_property_readonly("names", &Detector::names)
      .def(
          "fitted",
          [](const Detector& detector, const py::object& photograph, bool unchecked) {
            return numbers_of(detector.input(colours_of<3>("a photograph", photograph, unchecked)));
          },
          py::arg("photograph"), py::arg("unchecked") = false,
          "[h, w, 3], RGB in [0, 1], as a batch of one picture of the input's extents.")
      .def(
          "forward",
          [](std::shared_ptr<Detector> detector, const py::object& pictures, bool unchecked) {
            const auto batch = colours_of<4>("pictures", pictures, unchecked);
            const py::gil_scoped_release others_may_run;
            return std::make_unique<Run>(std::move(detector), batch);
          },
          py::arg("pictures"), py::arg("unchecked") = false, "[N, height, width, 3], RGB in [0, 1].");
}

void add_run(py::module_& module) {
  py::class_<Run>(module, "Run")
      .def_property_readonly("logits", &Run::logits, "For each head [N, channels, rows, columns].")
      .def("boxes", &Run::boxes, py::arg("confidence") = 0.25, py::arg("overlap") = 0.45,
           "For each picture rows of left, top, right, bottom, score and class.")
      .def("pull_back", &Run::pull_back, py::arg("adjoints"),
           "The gradient by the pictures, of adjoints of the logits; None stands for zeros.");
}

void add_view(py::module_& module) {
  py::class_<View>(module, "View")
      .def(py::init<const std::string&, const std::string&, std::size_t, double, double, double, double,
                    std::size_t>(),
           py::arg("mesh"), py::arg("material") = "", py::arg("rows") = 64, py::arg("azimuth") = 0.7,
           py::arg("elevation") = 0.3, py::arg("distance") = 8, py::arg("field_of_view") = 0.8,
           py::arg("size") = 256, "An OBJ file seen from a sphere around its origin; angles in radians.")
      .def_property_readonly("texel_count", &View::texel_count)
      .def_property_readonly("coverage", &View::coverage, "[size, size], in [0, 1].")
      .def("render", &View::render, py::arg("texels"), py::arg("unchecked") = false,
           "[texel_count, 3] to a picture [size, size, 3].")
      .def("pull_back", &View::pull_back, py::arg("picture_adjoint"), "The transposed map of render.");
}
}  // namespace

PYBIND11_MODULE(tapestry, module) {
  module.doc() = "Detectors and a painted mesh, with gradients, as functions of NumPy arrays.";
  py::register_exception<Error>(module, "Error", PyExc_ValueError);
  add_detector(module);
  add_run(module);
  add_view(module);
}

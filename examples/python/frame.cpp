#include <tapestry/io/frame_file.hpp>
#include <tapestry/raster/fitted_camera.hpp>

#include "bindings.hpp"

namespace tapestry::python {
namespace {
using geometry::Camera;
using FramePointer = std::shared_ptr<io::Frame>;

/// \param matrix      [3, 4], x to the right, y down, z forward, from the world
/// \param intrinsics  [3, 3], in pixels
Camera camera_by_matrix(const py::object& matrix, const py::object& intrinsics, double height, double width) {
  const auto view = contiguous<double, 2>("view_from_world", matrix);
  const auto pixels = contiguous<double, 2>("intrinsics", intrinsics);
  if (view.shape(0) != 3 || view.shape(1) != 4)
    throw ShapeError({"view_from_world is ", view.shape(0), " x ", view.shape(1), ", expected 3 x 4"});
  if (pixels.shape(0) != 3 || pixels.shape(1) != 3)
    throw ShapeError({"intrinsics are ", pixels.shape(0), " x ", pixels.shape(1), ", expected 3 x 3"});
  geometry::Matrix3 rotation{};
  for (std::size_t i = 0; i < 3; ++i)
    std::copy_n(view.data(static_cast<py::ssize_t>(i), 0), 3, rotation[i].begin());
  return geometry::pinhole_camera({.focal_x = pixels.at(0, 0),
                                   .focal_y = pixels.at(1, 1),
                                   .centre_x = pixels.at(0, 2),
                                   .centre_y = pixels.at(1, 2),
                                   .width = width,
                                   .height = height,
                                   .skew = pixels.at(0, 1)},
                                  rotation, {view.at(0, 3), view.at(1, 3), view.at(2, 3)});
}

py::array_t<double> matrix_of(const Camera& camera) {
  Array<double, 2> matrix(Extents<2>{3, 4});
  for (std::size_t i = 0; i < 3; ++i) {
    std::ranges::copy(camera.rotation[i], matrix.data() + 4 * i);
    matrix(i, 3) = camera.translation[i];
  }
  return handed_over(std::move(matrix));
}

FramePointer frame_of_file(const std::string& path) {
  auto frame = released([&] { return std::make_shared<io::Frame>(io::read_frame(path)); });
  warn(frame->warnings);
  return frame;
}

std::vector<FramePointer> read_all(const std::string& folder) {
  std::vector<FramePointer> frames;
  for (const auto& path : io::frame_paths(folder)) frames.push_back(frame_of_file(path));
  return frames;
}

FramePointer frame_of(const py::object& photograph, const Camera& camera, const py::object& mask,
                      const std::optional<raster::Light>& light, const std::string& name) {
  io::Frame frame;
  frame.name = name;
  frame.image = image::to_bytes(colours_of<3>("a photograph", photograph));
  frame.camera = camera;
  if (!mask.is_none())
    frame.mask = copied<std::uint8_t, 2>(contiguous<float, 2>("a mask", mask),
                                         [](float share) { return static_cast<std::uint8_t>(share != 0); });
  frame.light = light;
  return std::make_shared<io::Frame>(std::move(frame));
}

py::object mask_of(const py::object& self) {
  const auto& mask = self.cast<const io::Frame&>().mask;
  return mask ? py::object(shown(*mask, self)) : py::none();
}

py::object label_of(const io::Frame& frame) {
  if (!frame.label) return py::none();
  const auto& [class_index, box] = *frame.label;
  return handed_over(
      Array<double, 1>{box.left(), box.top(), box.right(), box.bottom(), static_cast<double>(class_index)});
}

void add_camera(py::module_& module) {
  using py::arg;
  py::class_<Camera>(module, "Camera",
                     "A pinhole camera, by matrix: view_from_world [3, 4], with x to the right, y down and z "
                     "forward, and intrinsics [3, 3] for pictures of height x width pixels, pixel 0 of which "
                     "covers 0 to 1. Lengths are those of the mesh, angles radians.")
      .def(py::init(&camera_by_matrix), arg("view_from_world"), arg("intrinsics"), arg("height"),
           arg("width"))
      .def_static(
          "orbit", &geometry::orbit_camera, arg("azimuth"), arg("elevation"), arg("distance"),
          arg("target") = geometry::Vector3{0, 0, 0}, arg("field_of_view") = 0.8,
          "A camera on a sphere around the target, for square pictures; azimuth 0 is in front of a car.")
      .def_property_readonly("view_from_world", &matrix_of, "Rotation and translation, [3, 4].")
      .def(
          "fitted",
          [](const Camera& camera, std::size_t photo_height, std::size_t photo_width, std::size_t height,
             std::size_t width, const std::string& fit) {
            return raster::fitted_camera(camera, photo_height, photo_width, height, width,
                                         image::fit_by_name(fit).kind);
          },
          arg("photo_height"), arg("photo_width"), arg("height"), arg("width"), arg("fit") = "letterbox",
          "The camera that sees its photograph in its place in a detector's input of height x width pixels.");
}
}  // namespace

void add_frame(py::module_& module) {
  using py::arg;
  add_camera(module);
  py::class_<raster::Light>(module, "Light",
                            "Flat shading: colour * (ambient + directional * max(0, cosine of normal and "
                            "direction)); direction points to the light, colour is RGB.")
      .def(py::init<double, double, std::array<double, 3>, std::array<double, 3>>(), arg("ambient") = 0.5,
           arg("directional") = 0.5, arg("direction") = std::array<double, 3>{0, 0, 1},
           arg("colour") = std::array<double, 3>{1, 1, 1});
  py::class_<io::Frame, FramePointer>(
      module, "Frame",
      "A photograph with its camera and, where they are known, mask, light and label: a file .npz or .json, "
      "or a photograph [H, W, 3], a camera, a mask [H, W], not 0 where the car may show, and a light.")
      .def(py::init(&frame_of_file), arg("path"))
      .def(py::init(&frame_of), arg("photograph"), arg("camera"), arg("mask") = py::none(),
           arg("light") = py::none(), arg("name") = "photograph")
      .def_readonly("name", &io::Frame::name, "The name in messages: of a file its path.")
      .def_property_readonly(
          "photograph",
          [](const py::object& self) { return shown(self.cast<const io::Frame&>().image, self); },
          "Bytes, [H, W, 3], RGB, read-only.")
      .def_property_readonly("mask", &mask_of, "Bytes, [H, W], not 0 where the car may show; or None.")
      .def_property_readonly("label", &label_of, "Left, top, right, bottom in pixels, class; or None.")
      .def_property_readonly("camera", &io::camera_of, "The frame's camera, or that of its pose.")
      .def(
          "light",
          [](const io::Frame& frame, const std::string& space) {
            return io::frame_light(frame, image::colour_space_by_name(space));
          },
          arg("space") = "linear",
          "The light that the frame states, else a usual one, for a mesh of this space.");
  module.def("frames", &read_all, arg("folder"), "All frames of a folder, in the order of their names.");
}
}  // namespace tapestry::python

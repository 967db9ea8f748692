#include <tapestry/image/over.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/loss/smoothness.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "bindings.hpp"

namespace tapestry::python {
namespace {
using Floats = py::array_t<float>;

/// A mesh seen by a camera: the linear map from the texels of its texture to a picture.
class View {
 public:
  View(std::shared_ptr<const Mesh> mesh, const geometry::Camera& camera, std::size_t height,
       std::size_t width, const raster::Light& light, std::size_t samples)
      : mesh_(std::move(mesh)) {
    operator_ = released(
        [&] { return raster::texture_operator<float>(*mesh_, camera, height, width, light, samples); });
  }

  static Floats coverage(const py::object& self) {
    return shown(self.cast<const View&>().operator_.coverage, self);
  }

  [[nodiscard]] Floats render(const py::object& texels) const {
    auto colours = colours_of<2>("texels", texels);
    return handed_over(released([&] {
      return raster::render(operator_, raster::stored_texels(mesh_->pyramid, std::move(colours)));
    }));
  }

  [[nodiscard]] Floats pull_back(const py::object& picture_adjoint) const {
    const auto adjoint = numbers_of<3>("the picture's adjoint", picture_adjoint);
    auto gradient = zeros<float, 2>({operator_.texel_count, 3});
    released([&] {
      raster::render_adjoint(operator_, adjoint, gradient);
      if (mesh_->pyramid) {
        auto of_atlas = zeros<float, 2>({mesh_->texel_count(), 3});
        mesh_->pyramid->adjoint(std::move(gradient), of_atlas);
        gradient = std::move(of_atlas);
      }
    });
    return handed_over(std::move(gradient));
  }

 private:
  std::shared_ptr<const Mesh> mesh_;
  raster::TextureOperator<float> operator_;
};

Floats over(const py::object& front, const py::object& coverage, const py::object& background,
            std::size_t top, std::size_t left, const std::string& space) {
  return handed_over(image::over(colours_of<3>("front", front), numbers_of<2>("coverage", coverage),
                                 colours_of<3>("background", background), top, left,
                                 image::colour_space_by_name(space)));
}

py::tuple over_adjoint(const py::object& front, const py::object& coverage, const py::object& background,
                       const py::object& adjoint, std::size_t top, std::size_t left,
                       const std::string& space) {
  const auto laid = colours_of<3>("front", front), behind = colours_of<3>("background", background);
  const auto covered = numbers_of<2>("coverage", coverage);
  auto by_front = zeros<float, 3>(laid.shape()), by_background = zeros<float, 3>(behind.shape());
  auto by_coverage = zeros<float, 2>(covered.shape());
  image::over_adjoint(laid, covered, behind, numbers_of<3>("adjoint", adjoint), &by_front, &by_coverage,
                      &by_background, top, left, image::colour_space_by_name(space));
  return py::make_tuple(handed_over(std::move(by_front)), handed_over(std::move(by_coverage)),
                        handed_over(std::move(by_background)));
}

py::tuple smoothness(const py::object& picture, const py::object& mask) {
  const auto colours = colours_of<3>("picture", picture);
  const auto counted = numbers_of<2>("mask", mask);
  auto gradient = zeros<float, 3>(colours.shape());
  const float sum = loss::smoothness(colours, counted);
  loss::smoothness_adjoint(colours, counted, 1, gradient);
  return py::make_tuple(sum, handed_over(std::move(gradient)));
}

void add_view(py::module_& module) {
  using py::arg;
  py::class_<View>(
      module, "View",
      "A mesh seen by a camera in a picture of height x width pixels: the linear map from texels "
      "[T, 3], in the mesh's space, to the picture, with samples x samples places a pixel.")
      .def(py::init<std::shared_ptr<Mesh>, const geometry::Camera&, std::size_t, std::size_t,
                    const raster::Light&, std::size_t>(),
           arg("mesh"), arg("camera"), arg("height"), arg("width"),
           py::arg_v("light", raster::Light{}, "Light()"), arg("samples") = 2)
      .def_property_readonly("coverage", &View::coverage,
                             "Share of each pixel that shows the mesh, [height, width] in [0, 1], read-only.")
      .def("render", &View::render, arg("texels"),
           "The picture of texels [T, 3], [height, width, 3], multiplied by its coverage.")
      .def("pull_back", &View::pull_back, arg("picture_adjoint"),
           "The transposed map, without materials of unpainted faces: [height, width, 3] to [T, 3].");
}
}  // namespace

void add_pictures(py::module_& module) {
  using py::arg;
  add_view(module);
  module.def(
      "over", &over, arg("front"), arg("coverage"), arg("background"), arg("top") = 0, arg("left") = 0,
      arg("space") = "encoded",
      "Lays a picture [h, w, 3], multiplied by its coverage [h, w], over a background [H, W, 3] at row "
      "top and column left. In linear space front is light, background and result are encoded.");
  module.def("over_adjoint", &over_adjoint, arg("front"), arg("coverage"), arg("background"), arg("adjoint"),
             arg("top") = 0, arg("left") = 0, arg("space") = "encoded",
             "Gradients of over by front, coverage and background, from the result's adjoint [H, W, 3].");
  module.def(
      "smoothness", &smoothness, arg("picture"), arg("mask"),
      "Squared colour steps of a picture [H, W, 3] within a mask [H, W]: their sum, and its gradient.");
  module.def(
      "linearised",
      [](const py::object& colours) {
        return handed_over(image::linearised(colours_of<2>("colours", colours)));
      },
      arg("colours"), "The light of encoded colours, [T, 3].");
  module.def(
      "read_picture", [](const std::string& path) { return handed_over(io::read_picture(path)); },
      arg("path"), "A PNG, JPEG, BMP, PNM or frame as bytes, [H, W, 3], RGB.");
  module.def(
      "png",
      [](const py::object& picture) {
        return py::bytes(io::png_file("png", colours_of<3>("picture", picture)));
      },
      arg("picture"), "A picture [H, W, 3] as the bytes of a PNG file.");
}
}  // namespace tapestry::python

// The Python module tapestry._tapestry: detectors, meshes, compositing, losses and camouflage as functions of
// NumPy arrays, each with the product of its transposed Jacobian, which is what a training framework calls
// backward.

#include "bindings.hpp"

PYBIND11_MODULE(_tapestry, module) {
  module.attr("__module__") = "tapestry";  // the package that the classes belong to
  module.attr("__version__") = TAPESTRY_VERSION_TEXT;
  pybind11::register_exception<tapestry::Error>(module, "Error", PyExc_ValueError).attr("__module__") =
      "tapestry";
  tapestry::python::add_detector(module);
  tapestry::python::add_mesh(module);
  tapestry::python::add_frame(module);
  tapestry::python::add_pictures(module);
  tapestry::python::add_camouflage(module);
}

#pragma once
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/io/frame.hpp>
#include <tapestry/raster/painted_mesh.hpp>

/// \file Conversions for all parts of the module: NumPy's arrays to the
/// library's, and back. The library's arrays own their numbers:
/// arguments are copied once, results are moved, and members of an
/// object are shown without a copy.

namespace tapestry::python {
namespace py = pybind11;

/// The result of a function during which other threads of Python run.
template <class Work>
auto released(Work work) {
  const py::gil_scoped_release others_may_run;
  return work();
}

/// An array or lists as contiguous numbers of one type.
/// \throws DomainError for anything but an array of numbers; ShapeError unless it has so many axes
template <class Element, std::size_t Rank>
[[nodiscard]] py::array_t<Element> contiguous(const char* name, const py::object& given) {
  using Contiguous = py::array_t<Element, py::array::c_style | py::array::forcecast>;
  const auto array = Contiguous::ensure(given);
  if (!array) {
    PyErr_Clear();
    throw DomainError({name, " is no array of numbers"});
  }
  if (array.ndim() != static_cast<py::ssize_t>(Rank))
    throw ShapeError({name, " has ", array.ndim(), " axes, expected ", Rank});
  return array;
}

/// The same as an array of the library, each number changed by a function.
template <class To, std::size_t Rank, class From, class Change>
[[nodiscard]] Array<To, Rank> copied(const py::array_t<From>& given, Change change) {
  Extents<Rank> shape{};
  for (std::size_t axis = 0; axis < Rank; ++axis)
    shape[axis] = static_cast<std::size_t>(given.shape(static_cast<py::ssize_t>(axis)));
  Array<To, Rank> array(shape);
  std::transform(given.data(), given.data() + array.size(), array.data(), change);
  return array;
}

/// Any numbers, such as an adjoint. Errors as contiguous().
template <std::size_t Rank>
[[nodiscard]] Array<float, Rank> numbers_of(const char* name, const py::object& given) {
  return copied<float, Rank>(contiguous<float, Rank>(name, given), [](float number) { return number; });
}

/// Colours, RGB: bytes from 0 to 255, or floating-point numbers in [0, 1], which may exceed this range
/// by 1, as an optimiser's do.
/// \throws DomainError for other types, for NaN, and for numbers farther away; ShapeError unless the last
/// axis
///         is of three channels; otherwise as contiguous()
template <std::size_t Rank>
[[nodiscard]] Array<float, Rank> colours_of(const char* name, const py::object& given) {
  constexpr const char* expected = ", expected bytes, or floating-point RGB in [0, 1]";
  const auto array = py::array::ensure(given);
  if (!array) {
    PyErr_Clear();
    throw DomainError({name, " is no array", expected});
  }
  const auto rank = static_cast<py::ssize_t>(Rank);
  if (array.ndim() == rank && array.shape(rank - 1) != 3)
    throw ShapeError({name, " has ", array.shape(rank - 1), " channels, expected 3"});
  const auto type = array.dtype();
  if (type.kind() == 'u' && type.itemsize() == 1)
    return copied<float, Rank>(contiguous<std::uint8_t, Rank>(name, array),
                               [](std::uint8_t byte) { return static_cast<float>(byte) / 255; });
  if (type.kind() != 'f')
    throw DomainError({name, " holds ", py::str(array.dtype()).cast<std::string>(), expected});
  return copied<float, Rank>(contiguous<float, Rank>(name, array), [&](float value) {
    if (!(value >= -1 && value <= 2)) throw DomainError({name, " holds ", value, expected});
    return value;
  });
}

/// An array that an object of Python keeps, read-only and without a copy.
template <class Element>
[[nodiscard]] py::array_t<Element> shown(const Element* first, std::vector<std::size_t> shape,
                                         const py::handle& owner) {
  py::array_t<Element> numbers(std::vector<py::ssize_t>(shape.begin(), shape.end()), first, owner);
  numbers.attr("setflags")(py::arg("write") = false);
  return numbers;
}
template <class Element, std::size_t Rank>
[[nodiscard]] py::array_t<Element> shown(const Array<Element, Rank>& array, const py::handle& owner) {
  return shown(array.data(), {array.shape().begin(), array.shape().end()}, owner);
}

template <class Element, std::size_t Rank>
[[nodiscard]] py::array_t<Element> handed_over(Array<Element, Rank> array) {
  auto* const kept = new Array<Element, Rank>(std::move(array));
  const py::capsule owner(kept, [](void* pointer) { delete static_cast<Array<Element, Rank>*>(pointer); });
  return py::array_t<Element>(std::vector<py::ssize_t>(kept->shape().begin(), kept->shape().end()),
                              kept->data(), owner);
}

[[nodiscard]] inline detect::Box box_of(const float* row) {
  const auto rim = [&](std::size_t i) { return static_cast<double>(row[i]); };
  return detect::box_from_corners(rim(0), rim(1), rim(2), rim(3));
}

[[nodiscard]] inline py::dict dict_of(const camouflage::ObjectiveTerms& terms) {
  py::dict values;
  for (const auto& term : camouflage::ObjectiveTerms::all) values[term.name] = terms.*term.value;
  return values;
}

/// Issues the library's warnings as Python's. \throws if Python turns them into errors
inline void warn(const std::vector<std::string>& warnings) {
  for (const auto& text : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

/// A painted mesh, and whether it has length 2, as frames without a camera need.
struct Mesh : raster::PaintedMesh {
  bool is_normalised = false;

  [[nodiscard]] std::size_t texel_count() const { return layout.texel_count(mesh); }

  /// \throws DomainError for a frame that sees a mesh of another size
  void require_seen_by(const io::Frame& frame) const {
    if (frame.camera.has_value() != is_normalised) return;
    throw DomainError({"frame ", frame.name,
                       is_normalised
                           ? " has a camera, which sees the mesh as it is: leave out normalised=True"
                           : " has poses and no camera, which see a mesh of length 2: normalised=True"});
  }
};

void add_detector(py::module_& module);
void add_mesh(py::module_& module);
void add_frame(py::module_& module);
void add_pictures(py::module_& module);
void add_camouflage(py::module_& module);
}  // namespace tapestry::python

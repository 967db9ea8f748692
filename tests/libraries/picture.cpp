#include <cstddef>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/image/batch.hpp>

// A shared library that hides its symbols and links tapestry::compiled. Two of these are made.
extern "C" {
/// d Σ x² / dx of a picture of x everywhere, by way of an operation of the compiled library. Calls
/// `meanwhile` in the middle of the recording, and again within a loop.
[[gnu::visibility("default")]] double picture_slope(double x, double (*meanwhile)(double));
/// The thread limit that the compiled part of the library sees after this one has set it.
[[gnu::visibility("default")]] int picture_threads(int limit);
}

using Picture = tapestry::ArrayVariable<double, 3>;

double picture_slope(double x, double (*meanwhile)(double)) {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  tapestry::Array<double, 3> values(tapestry::Extents<3>{1, 2, 3});
  for (double& value : values.storage()) value = x;
  const Picture picture = tape.input(values);
  const auto batch = tapestry::image::batch_of(std::vector<Picture>{picture, picture});
  if (meanwhile != nullptr) static_cast<void>(meanwhile(x + 1));
  const tapestry::Variable<double> root = sum(batch * batch) / 2.0;
  tape.reverse(root);
  tapestry::parallel_for(2, [&](std::size_t i) {
    if (i == 1 && meanwhile != nullptr) static_cast<void>(meanwhile(x + 2));
  });
  return picture.adjoint().data()[5];
}
int picture_threads(int limit) {
  tapestry::limit_threads(limit);
  return tapestry::thread_count();
}

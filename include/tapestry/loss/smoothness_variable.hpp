#pragma once
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/smoothness.hpp>
#include <vector>
namespace tapestry::loss {

/// The sum of smoothness() over pictures, as one record on the active tape.
///
/// \param pictures  each [H, W, C], as raster::render() gives them
/// \param masks     of each picture [H, W]; the tape keeps them alive
/// \throws ShapeError if a mask does not fit its picture
template <class T>
[[nodiscard]] Variable<T> smoothness(const std::vector<ArrayVariable<T, 3>>& pictures,
                                     std::vector<std::shared_ptr<const Array<T, 2>>> masks) {
  std::vector<double> sums(pictures.size());
  parallel_for(pictures.size(), [&](std::size_t n) {
    sums[n] = static_cast<double>(smoothness(pictures[n].value(), *masks[n]));
  });
  double sum = 0;
  for (const double s : sums) sum += s;
  std::vector<std::shared_ptr<const Array<T, 3>>> values;
  for (const auto& p : pictures) values.push_back(p.shared_value());
  return record_scalar(
      static_cast<T>(sum),
      [values, masks](T adjoint, const std::vector<Array<T, 3>*>& adjoints) {
        parallel_for(values.size(), [&](std::size_t n) {
          if (adjoints[n] != nullptr) smoothness_adjoint(*values[n], *masks[n], adjoint, *adjoints[n]);
        });
      },
      pictures);
}

/// atlas_smoothness() on the active tape.
///
/// \param texels  [texel, 3]
/// \param used    [height, width] of the atlas, 1 where a step counts; the tape keeps it alive
/// \throws ShapeError as atlas_smoothness()
template <class T>
[[nodiscard]] Variable<T> atlas_smoothness(const ArrayVariable<T, 2>& texels,
                                           std::shared_ptr<const Array<T, 2>> used) {
  return record_scalar(
      atlas_smoothness(texels.value(), *used),
      [used, values = texels.shared_value()](T adjoint, Array<T, 2>* texels_adjoint) {
        atlas_smoothness_adjoint(*values, *used, adjoint, *texels_adjoint);
      },
      texels);
}
}  // namespace tapestry::loss

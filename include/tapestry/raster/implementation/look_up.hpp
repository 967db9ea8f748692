#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/raster/deferred.hpp>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {
namespace detail {
/// Bilinear lookup at one pixel of uv, as visit_picture_taps() has it.
struct LookUp {
  AxisTaps column, row;
  double columns_by_u, rows_by_v;  ///< change of the taps' shares; 0 before the first texel's centre

  template <std::floating_point T>
  LookUp(const Array<T, 3>& texture, const T* uv)
      : LookUp(wrapped(static_cast<double>(uv[0]), 1) * static_cast<double>(texture.shape(1)) - 0.5,
               (1 - wrapped(static_cast<double>(uv[1]), 1)) * static_cast<double>(texture.shape(0)) - 0.5,
               texture.shape(0), texture.shape(1)) {}

  /// Calls visit(first entry of a texel, weight, its slopes by u and by v) for the four texels.
  template <class Visit>
  void visit(std::size_t width, std::size_t channels, Visit visit) const {
    for (const bool is_below : {false, true})
      for (const bool is_right : {false, true}) {
        const double down = is_below ? row.share : 1 - row.share;
        const double along = is_right ? column.share : 1 - column.share;
        const std::size_t i = is_below ? row.second : row.first, j = is_right ? column.second : column.first;
        visit((i * width + j) * channels, down * along, (is_right ? down : -down) * columns_by_u,
              (is_below ? along : -along) * rows_by_v);
      }
  }

 private:
  LookUp(double x, double y, std::size_t height, std::size_t width)
      : column(x, width),
        row(y, height),
        columns_by_u(x >= 0 ? static_cast<double>(width) : 0),
        rows_by_v(y >= 0 ? -static_cast<double>(height) : 0) {}
};

template <std::floating_point T>
void require_texture(const char* operation, const Array<T, 3>& texture, const Array<T, 3>& uv) {
  require_shape(operation, "uv", uv, {uv.shape(0), uv.shape(1), 2});
  if (texture.size() == 0) throw ShapeError({operation, ": the texture has no texel, expected one at least"});
}
}  // namespace detail

template <std::floating_point T>
Array<T, 3> look_up(const Array<T, 3>& texture, const Array<T, 3>& uv) {
  detail::require_texture("look_up", texture, uv);
  const std::size_t channels = texture.shape(2);
  auto out = zeros<T, 3>({uv.shape(0), uv.shape(1), channels});
  parallel_for(uv.shape(0), [&](std::size_t row) {
    for (std::size_t pixel = row * uv.shape(1); pixel < (row + 1) * uv.shape(1); ++pixel)
      detail::LookUp(texture, uv.data() + 2 * pixel)
          .visit(texture.shape(1), channels, [&](std::size_t texel, double weight, double, double) {
            for (std::size_t c = 0; c < channels; ++c)
              out.data()[pixel * channels + c] += static_cast<T>(weight) * texture.data()[texel + c];
          });
  });
  return out;
}

template <std::floating_point T>
void look_up_adjoint(const Array<T, 3>& texture, const Array<T, 3>& uv, const Array<T, 3>& out_adjoint,
                     Array<T, 3>* texture_adjoint, Array<T, 3>* uv_adjoint) {
  detail::require_texture("look_up_adjoint", texture, uv);
  const std::size_t channels = texture.shape(2);
  require_shape("look_up_adjoint", "out_adjoint", out_adjoint, {uv.shape(0), uv.shape(1), channels});
  if (texture_adjoint != nullptr)
    require_shape("look_up_adjoint", "texture_adjoint", *texture_adjoint, texture.shape());
  if (uv_adjoint != nullptr) require_shape("look_up_adjoint", "uv_adjoint", *uv_adjoint, uv.shape());
  for (std::size_t pixel = 0; pixel < uv.shape(0) * uv.shape(1); ++pixel) {
    const T* const adjoint = out_adjoint.data() + pixel * channels;
    double by_u = 0, by_v = 0;
    detail::LookUp(texture, uv.data() + 2 * pixel)
        .visit(texture.shape(1), channels, [&](std::size_t texel, double weight, double of_u, double of_v) {
          for (std::size_t c = 0; c < channels; ++c) {
            const auto product = static_cast<double>(adjoint[c] * texture.data()[texel + c]);
            by_u += of_u * product;
            by_v += of_v * product;
            if (texture_adjoint != nullptr)
              texture_adjoint->data()[texel + c] += static_cast<T>(weight) * adjoint[c];
          }
        });
    if (uv_adjoint == nullptr) continue;
    uv_adjoint->data()[2 * pixel] += static_cast<T>(by_u);
    uv_adjoint->data()[2 * pixel + 1] += static_cast<T>(by_v);
  }
}

template <std::floating_point T>
ArrayVariable<T, 3> look_up(const std::type_identity_t<ArrayVariable<T, 3>>& texture,
                            const ArrayVariable<T, 3>& uv) {
  const auto pullback = [texels = texture.shared_value(), at = uv.shared_value()](
                            const Array<T, 3>& adjoint, Array<T, 3>* texture_adjoint,
                            Array<T, 3>* uv_adjoint) {
    look_up_adjoint(*texels, *at, adjoint, texture_adjoint, uv_adjoint);
  };
  return record_array(look_up(texture.value(), uv.value()), pullback, texture, uv);
}
}  // namespace tapestry::raster

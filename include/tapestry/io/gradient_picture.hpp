#pragma once
#include <concepts>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::io {

/// Writes the gradient of a picture as a picture, for people to look at: grey where it is 0, brighter where
/// more of a colour raises the value and darker where less does.
///
///   ½ + ½ · ∛(g / max |g|)
///
/// The cube root shows what is small beside the largest, a thousandth by a tenth.
///
/// \param gradient  [1, H, W, 3]
/// \throws ShapeError for other extents; NumericError for what is not finite; FileError (write)
template <std::floating_point T>
void write_gradient(const std::string& path, const Array<T, 4>& gradient);

}  // namespace tapestry::io

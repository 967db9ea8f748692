#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <type_traits>

namespace tapestry::image {
/// A user's transformation of pictures: a type with two functions in its own namespace, as each
/// transformation here has, for float and double:
///
///   Array<T, 3> transformed(const Array<T, 3>& picture, const Own& own);
///   void transformed_adjoint(const Array<T, 3>& picture, const Own& own, const Array<T, 3>& out_adjoint,
///                            Array<T, 3>& picture_adjoint);  // adds
///
/// Both may run on several threads at once, each on another picture.
template <class Own, class Scalar>
concept TransformsPictures = requires(const Own& own, const Array<Scalar, 3>& picture,
                                      Array<Scalar, 3>& adjoint) {
  { transformed(picture, own) } -> std::convertible_to<Array<Scalar, 3>>;
  transformed_adjoint(picture, own, picture, adjoint);
};

template <class Own>
concept TransformsAllPictures = TransformsPictures<Own, float> && TransformsPictures<Own, double>;

/// A link of a TransformationChain that holds a user's transformation. Copies share it.
class OwnTransformation {
 public:
  template <class Own>
  requires(!std::same_as<std::remove_cvref_t<Own>, OwnTransformation> && TransformsAllPictures<Own>)
      OwnTransformation(Own own)
      : held_(std::make_shared<const Model<Own>>(std::move(own))) {}

  /// \throws ShapeError if the result has other extents than the picture, or as the user's function
  template <std::floating_point T>
  [[nodiscard]] Array<T, 3> apply(const Array<T, 3>& picture) const {
    Array<T, 3> out = held_->apply(picture);
    require_shape("transformed", "the result of an own transformation", out, picture.shape());
    return out;
  }

  /// Adds the derivatives of apply() to picture_adjoint; all are [H, W, 3].
  template <std::floating_point T>
  void add_adjoint(const Array<T, 3>& picture, const Array<T, 3>& out_adjoint,
                   Array<T, 3>& picture_adjoint) const {
    require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
    require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
    held_->add_adjoint(picture, out_adjoint, picture_adjoint);
  }

 private:
  template <std::floating_point T>
  struct Interface {
    virtual ~Interface() = default;
    [[nodiscard]] virtual Array<T, 3> apply(const Array<T, 3>& picture) const = 0;
    virtual void add_adjoint(const Array<T, 3>& picture, const Array<T, 3>& out_adjoint,
                             Array<T, 3>& picture_adjoint) const = 0;
  };
  struct AnyScalar : Interface<float>, Interface<double> {
    using Interface<float>::apply, Interface<double>::apply;
    using Interface<float>::add_adjoint, Interface<double>::add_adjoint;
  };

  template <class Own>
  struct Model final : AnyScalar {
    explicit Model(Own given) : own(std::move(given)) {}
    Array<float, 3> apply(const Array<float, 3>& picture) const override { return transformed(picture, own); }
    Array<double, 3> apply(const Array<double, 3>& picture) const override {
      return transformed(picture, own);
    }
    void add_adjoint(const Array<float, 3>& picture, const Array<float, 3>& out_adjoint,
                     Array<float, 3>& picture_adjoint) const override {
      transformed_adjoint(picture, own, out_adjoint, picture_adjoint);
    }
    void add_adjoint(const Array<double, 3>& picture, const Array<double, 3>& out_adjoint,
                     Array<double, 3>& picture_adjoint) const override {
      transformed_adjoint(picture, own, out_adjoint, picture_adjoint);
    }
    Own own;
  };

  std::shared_ptr<const AnyScalar> held_;
};

// Neither function takes a type that only converts to an OwnTransformation: the concept
// above would depend on itself.

/// The picture after a user's transformation, [H, W, 3].
/// \throws ShapeError if that changes the picture's extents, or as the user's function
template <std::floating_point T, std::same_as<OwnTransformation> Own>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const Own& own) {
  return own.apply(picture);
}

/// Adds the derivatives of transformed() to `picture_adjoint`; all are [H, W, 3].
/// \throws ShapeError if extents differ, or as the user's function
template <std::floating_point T, std::same_as<OwnTransformation> Own>
void transformed_adjoint(const Array<T, 3>& picture, const Own& own, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint) {
  own.add_adjoint(picture, out_adjoint, picture_adjoint);
}
}  // namespace tapestry::image

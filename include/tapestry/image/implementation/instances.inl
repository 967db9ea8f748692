// The functions and classes of this room, for the scalar TAPESTRY_SCALAR; implementation.hpp and
// implementation_double.hpp include this file behind the bodies.

namespace tapestry::image {
template Array<TAPESTRY_SCALAR, 3> over<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& premultiplied,
                                                         const Array<TAPESTRY_SCALAR, 2>& coverage,
                                                         const Array<TAPESTRY_SCALAR, 3>& background,
                                                         std::size_t top, std::size_t left,
                                                         ColourSpace space);
template decltype(over_adjoint<TAPESTRY_SCALAR>) over_adjoint<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 3> over<TAPESTRY_SCALAR>(
    const ArrayVariable<TAPESTRY_SCALAR, 3>& premultiplied, const ArrayVariable<TAPESTRY_SCALAR, 2>& coverage,
    const ArrayVariable<TAPESTRY_SCALAR, 3>& background, std::size_t top, std::size_t left,
    ColourSpace space);
template ArrayVariable<TAPESTRY_SCALAR, 4> over<TAPESTRY_SCALAR>(
    const std::vector<ArrayVariable<TAPESTRY_SCALAR, 3>>& premultiplied,
    const std::vector<Backdrop<TAPESTRY_SCALAR>>& backdrops, ColourSpace space);
template ArrayVariable<TAPESTRY_SCALAR, 2> linearised<TAPESTRY_SCALAR, 2>(
    const ArrayVariable<TAPESTRY_SCALAR, 2>& colours);
template ArrayVariable<TAPESTRY_SCALAR, 3> linearised<TAPESTRY_SCALAR, 3>(
    const ArrayVariable<TAPESTRY_SCALAR, 3>& colours);
template ArrayVariable<TAPESTRY_SCALAR, 2> encoded<TAPESTRY_SCALAR, 2>(
    const ArrayVariable<TAPESTRY_SCALAR, 2>& light);
template ArrayVariable<TAPESTRY_SCALAR, 3> encoded<TAPESTRY_SCALAR, 3>(
    const ArrayVariable<TAPESTRY_SCALAR, 3>& light);
template Array<TAPESTRY_SCALAR, 3> resize_bilinear<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                                    std::size_t height, std::size_t width);
template decltype(resize_bilinear_adjoint<TAPESTRY_SCALAR>) resize_bilinear_adjoint<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 4> batch_of<TAPESTRY_SCALAR>(
    const std::vector<ArrayVariable<TAPESTRY_SCALAR, 3>>& pictures);
template Array<TAPESTRY_SCALAR, 3> transformed<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                                const Blur& blur);
template void transformed_adjoint<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture, const Blur& blur,
                                                   const Array<TAPESTRY_SCALAR, 3>& out_adjoint,
                                                   Array<TAPESTRY_SCALAR, 3>& picture_adjoint);
template Array<TAPESTRY_SCALAR, 3> transformed<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                                const SensorNoise& noise);
template void transformed_adjoint<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                   const SensorNoise& noise,
                                                   const Array<TAPESTRY_SCALAR, 3>& out_adjoint,
                                                   Array<TAPESTRY_SCALAR, 3>& picture_adjoint);
template Array<TAPESTRY_SCALAR, 3> transformed<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                                const LightChange& change);
template void transformed_adjoint<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                   const LightChange& change,
                                                   const Array<TAPESTRY_SCALAR, 3>& out_adjoint,
                                                   Array<TAPESTRY_SCALAR, 3>& picture_adjoint);
template decltype(transformation_stages<TAPESTRY_SCALAR>) transformation_stages<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 3> transformed<TAPESTRY_SCALAR>(Array<TAPESTRY_SCALAR, 3> picture,
                                                                const TransformationChain& chain);
template void transformed_adjoint<TAPESTRY_SCALAR>(const std::vector<Array<TAPESTRY_SCALAR, 3>>& stages,
                                                   const TransformationChain& chain,
                                                   const Array<TAPESTRY_SCALAR, 3>& out_adjoint,
                                                   Array<TAPESTRY_SCALAR, 3>& picture_adjoint);
template ArrayVariable<TAPESTRY_SCALAR, 4> transformed<TAPESTRY_SCALAR>(
    const ArrayVariable<TAPESTRY_SCALAR, 4>& pictures, const std::vector<TransformationChain>& chains);
template Array<TAPESTRY_SCALAR, 3> transformed<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                                const Warp& warp);
template void transformed_adjoint<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture, const Warp& warp,
                                                   const Array<TAPESTRY_SCALAR, 3>& out_adjoint,
                                                   Array<TAPESTRY_SCALAR, 3>& picture_adjoint);
template Array<TAPESTRY_SCALAR, 3> transformed<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                                const JpegCompression& jpeg);
template void transformed_adjoint<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>& picture,
                                                   const JpegCompression& jpeg,
                                                   const Array<TAPESTRY_SCALAR, 3>& out_adjoint,
                                                   Array<TAPESTRY_SCALAR, 3>& picture_adjoint);
}  // namespace tapestry::image

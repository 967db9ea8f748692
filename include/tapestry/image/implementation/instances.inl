// Instances for TAPESTRY_SCALAR; implementation.hpp and implementation_double.hpp include this file last.
#ifndef TAPESTRY_SCALAR  // an editor reads this file alone
#include <tapestry/image/implementation.hpp>
#define TAPESTRY_SCALAR double
#endif

namespace tapestry::image {
template Array<TAPESTRY_SCALAR, 3> over(const Array<TAPESTRY_SCALAR, 3>&, const Array<TAPESTRY_SCALAR, 2>&,
                                        const Array<TAPESTRY_SCALAR, 3>&, std::size_t, std::size_t,
                                        ColourSpace);
template decltype(over_adjoint<TAPESTRY_SCALAR>) over_adjoint<TAPESTRY_SCALAR>;
template decltype(over_tangent<TAPESTRY_SCALAR>) over_tangent<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 3> over(const ArrayVariable<TAPESTRY_SCALAR, 3>&,
                                                const ArrayVariable<TAPESTRY_SCALAR, 2>&,
                                                const ArrayVariable<TAPESTRY_SCALAR, 3>&, std::size_t,
                                                std::size_t, ColourSpace);
template ArrayVariable<TAPESTRY_SCALAR, 4> over(const std::vector<ArrayVariable<TAPESTRY_SCALAR, 3>>&,
                                                const std::vector<Backdrop<TAPESTRY_SCALAR>>&, ColourSpace);
template ArrayVariable<TAPESTRY_SCALAR, 2> linearised(const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template ArrayVariable<TAPESTRY_SCALAR, 3> linearised(const ArrayVariable<TAPESTRY_SCALAR, 3>&);
template ArrayVariable<TAPESTRY_SCALAR, 2> encoded(const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template ArrayVariable<TAPESTRY_SCALAR, 3> encoded(const ArrayVariable<TAPESTRY_SCALAR, 3>&);
template Array<TAPESTRY_SCALAR, 3> resize_bilinear(const Array<TAPESTRY_SCALAR, 3>&, std::size_t,
                                                   std::size_t);
template decltype(resize_bilinear_adjoint<TAPESTRY_SCALAR>) resize_bilinear_adjoint<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 4> batch_of(const std::vector<ArrayVariable<TAPESTRY_SCALAR, 3>>&);
template Array<TAPESTRY_SCALAR, 3> transformed(const Array<TAPESTRY_SCALAR, 3>&, const Blur&);
template void transformed_adjoint(const Array<TAPESTRY_SCALAR, 3>&, const Blur&,
                                  const Array<TAPESTRY_SCALAR, 3>&, Array<TAPESTRY_SCALAR, 3>&);
template Array<TAPESTRY_SCALAR, 3> transformed(const Array<TAPESTRY_SCALAR, 3>&, const SensorNoise&);
template void transformed_adjoint(const Array<TAPESTRY_SCALAR, 3>&, const SensorNoise&,
                                  const Array<TAPESTRY_SCALAR, 3>&, Array<TAPESTRY_SCALAR, 3>&);
template Array<TAPESTRY_SCALAR, 3> transformed(const Array<TAPESTRY_SCALAR, 3>&, const LightChange&);
template void transformed_adjoint(const Array<TAPESTRY_SCALAR, 3>&, const LightChange&,
                                  const Array<TAPESTRY_SCALAR, 3>&, Array<TAPESTRY_SCALAR, 3>&);
template decltype(transformation_stages<TAPESTRY_SCALAR>) transformation_stages<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 3> transformed(Array<TAPESTRY_SCALAR, 3>, const TransformationChain&);
template void transformed_adjoint(const std::vector<Array<TAPESTRY_SCALAR, 3>>&, const TransformationChain&,
                                  const Array<TAPESTRY_SCALAR, 3>&, Array<TAPESTRY_SCALAR, 3>&);
template ArrayVariable<TAPESTRY_SCALAR, 4> transformed(const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                       const std::vector<TransformationChain>&);
template Array<TAPESTRY_SCALAR, 3> transformed(const Array<TAPESTRY_SCALAR, 3>&, const Warp&);
template void transformed_adjoint(const Array<TAPESTRY_SCALAR, 3>&, const Warp&,
                                  const Array<TAPESTRY_SCALAR, 3>&, Array<TAPESTRY_SCALAR, 3>&);
template Array<TAPESTRY_SCALAR, 3> transformed(const Array<TAPESTRY_SCALAR, 3>&, const JpegCompression&);
template void transformed_adjoint(const Array<TAPESTRY_SCALAR, 3>&, const JpegCompression&,
                                  const Array<TAPESTRY_SCALAR, 3>&, Array<TAPESTRY_SCALAR, 3>&);
}  // namespace tapestry::image

// Instances for TAPESTRY_SCALAR; implementation.hpp and implementation_double.hpp include this file last.
#ifndef TAPESTRY_SCALAR  // an editor reads this file alone
#include <tapestry/detect/implementation.hpp>
#define TAPESTRY_SCALAR double
#endif

namespace tapestry::detect {
template std::vector<Detection> decode<TAPESTRY_SCALAR>(const std::vector<Head>&,
                                                        const std::vector<Array<TAPESTRY_SCALAR, 4>>&,
                                                        std::size_t, double, std::size_t, std::size_t);
template decltype(detail::decoded_heads<TAPESTRY_SCALAR>) detail::decoded_heads<TAPESTRY_SCALAR>;
template decltype(confidences<TAPESTRY_SCALAR>) confidences<TAPESTRY_SCALAR>;
template DecodedHead<TAPESTRY_SCALAR> decode<TAPESTRY_SCALAR>(const Head&,
                                                              const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                              std::size_t, std::size_t);
template class DarknetModel<TAPESTRY_SCALAR>;
template decltype(encode<TAPESTRY_SCALAR>) encode<TAPESTRY_SCALAR>;
template decltype(encode_adjoint<TAPESTRY_SCALAR>) encode_adjoint<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 4> encoded<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 4>&,
                                                            const InputEncoding&);
template decltype(encoded_adjoint<TAPESTRY_SCALAR>) encoded_adjoint<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 4> encoded<TAPESTRY_SCALAR>(const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                                    const InputEncoding&);
template struct Pass<TAPESTRY_SCALAR>;
template std::vector<ArrayVariable<TAPESTRY_SCALAR, 4>> forward<TAPESTRY_SCALAR>(
    const Detector<TAPESTRY_SCALAR>&, const ArrayVariable<TAPESTRY_SCALAR, 4>&,
    std::shared_ptr<Pass<TAPESTRY_SCALAR>>);
template decltype(forward_within<TAPESTRY_SCALAR>) forward_within<TAPESTRY_SCALAR>;
template std::vector<ArrayVariable<TAPESTRY_SCALAR, 4>> forward<TAPESTRY_SCALAR>(
    Detector<TAPESTRY_SCALAR>&, const ArrayVariable<TAPESTRY_SCALAR, 4>&,
    const ArrayVariable<TAPESTRY_SCALAR, 1>&, std::shared_ptr<Pass<TAPESTRY_SCALAR>>);
template decltype(forward_tangents<TAPESTRY_SCALAR>) forward_tangents<TAPESTRY_SCALAR>;
template decltype(best_candidate<TAPESTRY_SCALAR>) best_candidate<TAPESTRY_SCALAR>;
template decltype(grad_cam<TAPESTRY_SCALAR>) grad_cam<TAPESTRY_SCALAR>;
template decltype(grad_cam_plus_plus<TAPESTRY_SCALAR>) grad_cam_plus_plus<TAPESTRY_SCALAR>;
template decltype(layer_cam<TAPESTRY_SCALAR>) layer_cam<TAPESTRY_SCALAR>;
template decltype(share_within<TAPESTRY_SCALAR>) share_within<TAPESTRY_SCALAR>;
template decltype(score_adjoint<TAPESTRY_SCALAR>) score_adjoint<TAPESTRY_SCALAR>;
template decltype(explained_forward<TAPESTRY_SCALAR>) explained_forward<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 1> fold_batch_norm<TAPESTRY_SCALAR>(const NetworkConfig&,
                                                                    const ParameterLayout&,
                                                                    const Array<TAPESTRY_SCALAR, 1>&);
template decltype(network_description<TAPESTRY_SCALAR>) network_description<TAPESTRY_SCALAR>;
template class Detector<TAPESTRY_SCALAR>;
template decltype(detail::shared_logits<TAPESTRY_SCALAR>) detail::shared_logits<TAPESTRY_SCALAR>;
template decltype(detail::record_logits<TAPESTRY_SCALAR>) detail::record_logits<TAPESTRY_SCALAR>;
}  // namespace tapestry::detect

// The functions and classes of this room, for the scalar TAPESTRY_SCALAR; implementation.hpp and
// implementation_double.hpp include this file behind the bodies.

namespace tapestry::detect {
template std::vector<Detection> decode<TAPESTRY_SCALAR>(const std::vector<Head>& heads,
                                                        const std::vector<Array<TAPESTRY_SCALAR, 4>>& logits,
                                                        std::size_t image, double confidence_threshold,
                                                        std::size_t input_height, std::size_t input_width);
template decltype(detail::decoded_heads<TAPESTRY_SCALAR>) detail::decoded_heads<TAPESTRY_SCALAR>;
template decltype(confidences<TAPESTRY_SCALAR>) confidences<TAPESTRY_SCALAR>;
template DecodedHead<TAPESTRY_SCALAR> decode<TAPESTRY_SCALAR>(const Head& head,
                                                              const ArrayVariable<TAPESTRY_SCALAR, 4>& logits,
                                                              std::size_t input_height,
                                                              std::size_t input_width);
template class DarknetModel<TAPESTRY_SCALAR>;
template decltype(encode<TAPESTRY_SCALAR>) encode<TAPESTRY_SCALAR>;
template decltype(encode_adjoint<TAPESTRY_SCALAR>) encode_adjoint<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 4> encoded<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 4>& pictures,
                                                            const InputEncoding& encoding);
template decltype(encoded_adjoint<TAPESTRY_SCALAR>) encoded_adjoint<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 4> encoded<TAPESTRY_SCALAR>(
    const ArrayVariable<TAPESTRY_SCALAR, 4>& pictures, const InputEncoding& encoding);
template struct Pass<TAPESTRY_SCALAR>;
template std::vector<ArrayVariable<TAPESTRY_SCALAR, 4>> forward<TAPESTRY_SCALAR>(
    const Detector<TAPESTRY_SCALAR>& detector, const ArrayVariable<TAPESTRY_SCALAR, 4>& images,
    std::shared_ptr<Pass<TAPESTRY_SCALAR>> pass);
template decltype(forward_within<TAPESTRY_SCALAR>) forward_within<TAPESTRY_SCALAR>;
template std::vector<ArrayVariable<TAPESTRY_SCALAR, 4>> forward<TAPESTRY_SCALAR>(
    Detector<TAPESTRY_SCALAR>& detector, const ArrayVariable<TAPESTRY_SCALAR, 4>& images,
    const ArrayVariable<TAPESTRY_SCALAR, 1>& weights, std::shared_ptr<Pass<TAPESTRY_SCALAR>> pass);
template decltype(best_candidate<TAPESTRY_SCALAR>) best_candidate<TAPESTRY_SCALAR>;
template decltype(grad_cam<TAPESTRY_SCALAR>) grad_cam<TAPESTRY_SCALAR>;
template decltype(grad_cam_plus_plus<TAPESTRY_SCALAR>) grad_cam_plus_plus<TAPESTRY_SCALAR>;
template decltype(layer_cam<TAPESTRY_SCALAR>) layer_cam<TAPESTRY_SCALAR>;
template decltype(share_within<TAPESTRY_SCALAR>) share_within<TAPESTRY_SCALAR>;
template decltype(score_adjoint<TAPESTRY_SCALAR>) score_adjoint<TAPESTRY_SCALAR>;
template decltype(explained_forward<TAPESTRY_SCALAR>) explained_forward<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 1> fold_batch_norm<TAPESTRY_SCALAR>(
    const NetworkConfig& config, const ParameterLayout& layout, const Array<TAPESTRY_SCALAR, 1>& parameters);
template decltype(network_description<TAPESTRY_SCALAR>) network_description<TAPESTRY_SCALAR>;
}  // namespace tapestry::detect

namespace tapestry::detect {
template class Detector<TAPESTRY_SCALAR>;
}  // namespace tapestry::detect

namespace tapestry::detect::detail {
template decltype(shared_logits<TAPESTRY_SCALAR>) shared_logits<TAPESTRY_SCALAR>;
template decltype(record_logits<TAPESTRY_SCALAR>) record_logits<TAPESTRY_SCALAR>;
}  // namespace tapestry::detect::detail

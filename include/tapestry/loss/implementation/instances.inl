// Instances for TAPESTRY_SCALAR; implementation.hpp and implementation_double.hpp include this file last.
#ifndef TAPESTRY_SCALAR  // an editor reads this file alone
#include <tapestry/loss/implementation.hpp>
#define TAPESTRY_SCALAR double
#endif

namespace tapestry::loss::detail {
template decltype(terms_adjoint<TAPESTRY_SCALAR>) terms_adjoint<TAPESTRY_SCALAR>;
template decltype(adversarial_of<TAPESTRY_SCALAR>) adversarial_of<TAPESTRY_SCALAR>;
template decltype(miss<TAPESTRY_SCALAR>) miss<TAPESTRY_SCALAR>;
template decltype(row<TAPESTRY_SCALAR>) row<TAPESTRY_SCALAR>;
template decltype(yolo_training_of<TAPESTRY_SCALAR>) yolo_training_of<TAPESTRY_SCALAR>;
template decltype(yolox_training_of<TAPESTRY_SCALAR>) yolox_training_of<TAPESTRY_SCALAR>;
}  // namespace tapestry::loss::detail

namespace tapestry::loss {
template AdversarialTerms<TAPESTRY_SCALAR> adversarial(const Predictions<TAPESTRY_SCALAR>&, const Target&,
                                                       AdversarialLoss, const AdversarialWeights&);
template decltype(adversarial_adjoint<TAPESTRY_SCALAR>) adversarial_adjoint<TAPESTRY_SCALAR>;
template decltype(mean_of<TAPESTRY_SCALAR>) mean_of<TAPESTRY_SCALAR>;
template decltype(vanish<TAPESTRY_SCALAR>) vanish<TAPESTRY_SCALAR>;
template decltype(vanish_adjoint<TAPESTRY_SCALAR>) vanish_adjoint<TAPESTRY_SCALAR>;
template decltype(max_score<TAPESTRY_SCALAR>) max_score<TAPESTRY_SCALAR>;
template decltype(max_score_adjoint<TAPESTRY_SCALAR>) max_score_adjoint<TAPESTRY_SCALAR>;
template TAPESTRY_SCALAR attention(const Array<TAPESTRY_SCALAR, 2>&);
template decltype(attention_adjoint<TAPESTRY_SCALAR>) attention_adjoint<TAPESTRY_SCALAR>;
template Variable<TAPESTRY_SCALAR> attention(const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template TAPESTRY_SCALAR binary_cross_entropy(const Array<TAPESTRY_SCALAR, 4>&,
                                              const Array<TAPESTRY_SCALAR, 4>&);
template TAPESTRY_SCALAR cross_entropy(const Array<TAPESTRY_SCALAR, 4>&, const Array<TAPESTRY_SCALAR, 4>&);
template decltype(binary_cross_entropy_adjoint<TAPESTRY_SCALAR>)
    binary_cross_entropy_adjoint<TAPESTRY_SCALAR>;
template decltype(cross_entropy_adjoint<TAPESTRY_SCALAR>) cross_entropy_adjoint<TAPESTRY_SCALAR>;
template Variable<TAPESTRY_SCALAR> binary_cross_entropy(const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                        std::shared_ptr<const Array<TAPESTRY_SCALAR, 4>>);
template Variable<TAPESTRY_SCALAR> cross_entropy(const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                 std::shared_ptr<const Array<TAPESTRY_SCALAR, 4>>);
template decltype(dynamic_matches<TAPESTRY_SCALAR>) dynamic_matches<TAPESTRY_SCALAR>;
template TAPESTRY_SCALAR laplacian(const geometry::MeshTopology&, const Array<TAPESTRY_SCALAR, 2>&);
template decltype(laplacian_adjoint<TAPESTRY_SCALAR>) laplacian_adjoint<TAPESTRY_SCALAR>;
template TAPESTRY_SCALAR edge_length(const geometry::MeshTopology&, const Array<TAPESTRY_SCALAR, 2>&, double);
template decltype(edge_length_adjoint<TAPESTRY_SCALAR>) edge_length_adjoint<TAPESTRY_SCALAR>;
template TAPESTRY_SCALAR normal_consistency(const geometry::MeshTopology&, const Array<TAPESTRY_SCALAR, 2>&);
template decltype(normal_consistency_adjoint<TAPESTRY_SCALAR>) normal_consistency_adjoint<TAPESTRY_SCALAR>;
template Variable<TAPESTRY_SCALAR> laplacian(const geometry::MeshTopology&,
                                             const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template Variable<TAPESTRY_SCALAR> edge_length(const geometry::MeshTopology&,
                                               const ArrayVariable<TAPESTRY_SCALAR, 2>&, double);
template Variable<TAPESTRY_SCALAR> normal_consistency(const geometry::MeshTopology&,
                                                      const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template Variable<TAPESTRY_SCALAR> non_printability(const ArrayVariable<TAPESTRY_SCALAR, 2>&,
                                                    std::shared_ptr<const Array<TAPESTRY_SCALAR, 2>>,
                                                    std::shared_ptr<const Array<double, 2>>, double);
template YoloTrainingTerms yolo_training(const std::vector<detect::Head>&, const LogitsView<TAPESTRY_SCALAR>&,
                                         const Truths&, std::size_t, std::size_t, const YoloTrainingOptions&);
template decltype(yolo_training_adjoint<TAPESTRY_SCALAR>) yolo_training_adjoint<TAPESTRY_SCALAR>;
template YoloTrainingTerms yolox_training(const std::vector<detect::Head>&,
                                          const LogitsView<TAPESTRY_SCALAR>&, const DynamicMatches&,
                                          std::size_t, std::size_t, const YoloxTrainingOptions&);
template decltype(yolox_training_adjoint<TAPESTRY_SCALAR>) yolox_training_adjoint<TAPESTRY_SCALAR>;
}  // namespace tapestry::loss

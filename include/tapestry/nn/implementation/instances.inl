// Instances for TAPESTRY_SCALAR; implementation.hpp and implementation_double.hpp include this file last.
#ifndef TAPESTRY_SCALAR  // an editor reads this file alone
#include <tapestry/nn/implementation.hpp>
#define TAPESTRY_SCALAR double
#endif

namespace tapestry::nn {
template class Network<TAPESTRY_SCALAR>;
template class NetworkPass<TAPESTRY_SCALAR>;
template const OperatorTable<TAPESTRY_SCALAR>& operators<TAPESTRY_SCALAR>();
template class ProgramBuilder<TAPESTRY_SCALAR>;
template class StagedNetwork<TAPESTRY_SCALAR>;
template std::vector<ArrayVariable<TAPESTRY_SCALAR, 4>> forward<TAPESTRY_SCALAR>(
    const Network<TAPESTRY_SCALAR>&, const ArrayVariable<TAPESTRY_SCALAR, 4>&,
    std::shared_ptr<NetworkPass<TAPESTRY_SCALAR>>);
template std::vector<ArrayVariable<TAPESTRY_SCALAR, 4>> forward<TAPESTRY_SCALAR>(
    Network<TAPESTRY_SCALAR>&, const ArrayVariable<TAPESTRY_SCALAR, 4>&,
    const ArrayVariable<TAPESTRY_SCALAR, 1>&, std::shared_ptr<NetworkPass<TAPESTRY_SCALAR>>);
template ArrayVariable<TAPESTRY_SCALAR, 4> convolve<TAPESTRY_SCALAR>(const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                                     const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                                     const ArrayVariable<TAPESTRY_SCALAR, 1>&,
                                                                     const ConvolutionLayer&);
template ArrayVariable<TAPESTRY_SCALAR, 4> convolve<TAPESTRY_SCALAR>(const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                                     const ArrayVariable<TAPESTRY_SCALAR, 4>&,
                                                                     const ConvolutionLayer&);
template decltype(max_pool<TAPESTRY_SCALAR>) max_pool<TAPESTRY_SCALAR>;
template decltype(average_pool<TAPESTRY_SCALAR>) average_pool<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 4> batch_norm<TAPESTRY_SCALAR>(
    const ArrayVariable<TAPESTRY_SCALAR, 4>&, const ArrayVariable<TAPESTRY_SCALAR, 1>&,
    const ArrayVariable<TAPESTRY_SCALAR, 1>&, double);
template Kernels<TAPESTRY_SCALAR> kernels_of<TAPESTRY_SCALAR>(InstructionSet);
}  // namespace tapestry::nn

#pragma once

namespace tapestry::nn {

/// Purpose of a forward pass; it decides what the pass keeps.
enum class Mode {
  inference,       ///< running statistics; nothing is kept but the results
  input_gradient,  ///< running statistics; slopes and choices are kept for the adjoint of the input
  training,        ///< statistics of the batch; everything is kept for either adjoint
};

}  // namespace tapestry::nn

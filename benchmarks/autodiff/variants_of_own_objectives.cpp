// Variants of the objectives of losses and renderers.
#include "variant_definitions.hpp"

namespace tapestry::benchmarks {
template Made make_variant(const Softmax&, const std::string&, std::ptrdiff_t);
template Made make_variant(const Iou&, const std::string&, std::ptrdiff_t);
template Made make_variant(const Smoothness&, const std::string&, std::ptrdiff_t);
template Made make_variant(const Project&, const std::string&, std::ptrdiff_t);
template Made make_variant(const Speelpenning&, const std::string&, std::ptrdiff_t);
template Made make_variant(const Recurrence&, const std::string&, std::ptrdiff_t);
template Made make_variant(const Ciou&, const std::string&, std::ptrdiff_t);
template Made make_variant(const MatmulChain&, const std::string&, std::ptrdiff_t);
}  // namespace tapestry::benchmarks

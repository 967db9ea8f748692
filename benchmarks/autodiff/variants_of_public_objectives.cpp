// Variants of the objectives of the ADBench suite.
#include "variant_definitions.hpp"

namespace tapestry::benchmarks {
template Made make_variant(const Gmm&, const std::string&, std::ptrdiff_t);
template Made make_variant(const HandTracking&, const std::string&, std::ptrdiff_t);
template Made make_variant(const Bundle&, const std::string&, std::ptrdiff_t);
template Made make_variant(const BundleJacobian&, const std::string&, std::ptrdiff_t);
}  // namespace tapestry::benchmarks

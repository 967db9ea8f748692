// The objectives as this library differentiates them; and as plain code, and with adjoints by hand.

#include "float_sum_computations.hpp"
#include "variants.hpp"

namespace tapestry::benchmarks {
namespace {
[[nodiscard]] Made make_sum(const FloatSum& objective, const std::string& variant) {
  if (variant == "naive-float") return std::make_unique<NaiveSum<float>>(objective);
  if (variant == "plain") return std::make_unique<NaiveSum<double>>(objective);
  if (variant == "array-float") return std::make_unique<CompensatedArraySum>(objective);
  return nullptr;
}
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry::benchmarks;
  return run_worker(argc, argv,
                    [](const auto& objective, const std::string& variant, std::ptrdiff_t threads) -> Made {
                      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(objective)>, FloatSum>) {
                        return make_sum(objective, variant);
                      } else {
                        return make_variant(objective, variant, threads);
                      }
                    });
}

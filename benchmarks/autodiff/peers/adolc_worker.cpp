// The objectives as ADOL-C differentiates them: traced, and reversed with its driver for gradients. Its store
// grows with the largest trace of the process and stays, so that small traces cost more behind large ones.
// The published figures are of one process for all objectives in turn; so is this, but for the variant
// "fresh".
#include <adolc/adolc.h>

#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "../worker_program.hpp"

namespace tapestry::benchmarks {
namespace {

template <class Objective>
class AdolcTrace final : public Computation {
 public:
  explicit AdolcTrace(const Objective& objective) : objective_(objective), x_(objective.start()) {
    gradient_.resize(x_.size());
  }
  void run() override {
    constexpr short tag = 1;
    trace_on(tag);
    std::vector<adouble> inputs(x_.size());
    for (std::size_t i = 0; i < x_.size(); ++i) inputs[i] <<= x_[i];
    adouble result = objective_(inputs.data());
    result >>= value_;
    trace_off();
    ::gradient(tag, static_cast<int>(x_.size()), x_.data(), gradient_.data());
  }

 private:
  Objective objective_;
  std::vector<double> x_;
};

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry::benchmarks;
  return run_worker(argc, argv,
                    []<class Objective>(const Objective& objective,
                                        const std::string& variant) -> std::unique_ptr<Computation> {
                      bool is_before = variant != "peer:adolc-fresh";
                      for_each_objective([&]<class Other>(const Other& other) {
                        is_before = is_before && !std::is_same_v<Other, Objective>;
                        if (is_before) AdolcTrace<Other>(other).run();
                      });
                      return std::make_unique<AdolcTrace<Objective>>(objective);
                    });
}

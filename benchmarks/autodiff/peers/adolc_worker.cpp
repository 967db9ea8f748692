// The objectives as ADOL-C differentiates them: traced, and reversed with its driver for gradients. Its store
// grows with the largest trace of the process and stays, so that small traces cost more behind large ones.
// The published figures are of one process for all objectives in turn; so is this, but for the variant
// "fresh".
#include <adolc/adolc.h>

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

/// Its Jacobian an observation at a time: traced, then by its driver for Jacobians.
template <>
class AdolcTrace<BundleJacobian> final : public Computation {
  using B = BundleProblem;

 public:
  explicit AdolcTrace(const BundleJacobian& bundle) : bundle_(bundle), x_(bundle.start()) {
    gradient_.resize(BundleJacobian::entries);
  }
  void run() override {
    value_ = 0;
    for (std::size_t o = 0; o < B::observations; ++o) {
      const auto block = B::block_of(x_.data(), o);
      double errors[2];
      trace(block, o, errors);
      double* rows[2] = {gradient_.data() + 2 * B::block * o, gradient_.data() + (2 * o + 1) * B::block};
      ::jacobian(1, 2, static_cast<int>(B::block), block.data(), rows);
      const double weight = block[B::block - 1];
      gradient_[2 * B::block * B::observations + o] = -2 * weight;
      value_ += errors[0] + errors[1] + 1 - weight * weight;
    }
  }

 private:
  void trace(const std::array<double, B::block>& block, std::size_t o, double* values) const {
    trace_on(1);
    std::array<adouble, B::block> inputs;
    for (std::size_t k = 0; k < B::block; ++k) inputs[k] <<= block[k];
    adouble errors[2];
    B::reproject(inputs.data(), inputs.data() + B::camera_size, inputs[B::block - 1],
                 bundle_.seen.data() + 2 * o, errors);
    for (std::size_t e = 0; e < 2; ++e) errors[e] >>= values[e];
    trace_off();
  }

  BundleJacobian bundle_;
  std::vector<double> x_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry::benchmarks;
  return run_worker(argc, argv,
                    []<class Objective>(const Objective& objective, const std::string& variant,
                                        std::ptrdiff_t) -> std::unique_ptr<Computation> {
                      bool is_before = variant != "peer:adolc-fresh";
                      for_each_objective([&]<class Other>(const Other& other) {
                        is_before = is_before && !std::is_same_v<Other, Objective>;
                        if (is_before) AdolcTrace<Other>(other).run();
                      });
                      return std::make_unique<AdolcTrace<Objective>>(objective);
                    });
}

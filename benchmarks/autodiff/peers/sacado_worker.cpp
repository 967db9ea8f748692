// The objectives as Sacado's RAD differentiates them: recorded as they run, and reversed. Not the Jacobian,
// and not hand tracking: Sacado's numbers are copied from what may change alone, so that an array of them
// cannot be assigned.
#include <Sacado_trad.hpp>

#include "../worker_program.hpp"

namespace tapestry::benchmarks {
namespace {
template <class Objective>
class SacadoRecord final : public Computation {
 public:
  explicit SacadoRecord(const Objective& objective) : objective_(objective), x_(objective.start()) {
    gradient_.resize(x_.size());
  }
  void run() override {
    using Number = Sacado::Rad::ADvar<double>;
    std::vector<Number> inputs(x_.begin(), x_.end());
    value_ = Number(objective_(inputs.data())).val();
    Sacado::Rad::ADcontext<double>::Gradcomp();  // of the last result
    for (std::size_t i = 0; i < x_.size(); ++i) gradient_[i] = inputs[i].adj();
  }

 private:
  Objective objective_;
  std::vector<double> x_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry::benchmarks;
  return run_worker(
      argc, argv,
      []<class Objective>(const Objective& objective, const std::string&,
                          std::ptrdiff_t) -> std::unique_ptr<Computation> {
        if constexpr (std::is_same_v<Objective, BundleJacobian> || std::is_same_v<Objective, HandTracking>)
          return nullptr;
        else
          return std::make_unique<SacadoRecord<Objective>>(objective);
      });
}

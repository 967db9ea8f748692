#pragma once
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/compressed_jacobian.hpp>
#include "worker_program.hpp"

namespace tapestry::benchmarks {
/// Computes the Jacobian of BundleJacobian.
class JacobianComputation : public Computation {
 public:
  explicit JacobianComputation(const BundleJacobian& bundle) : bundle_(bundle), x_(bundle.start()) {
    gradient_.resize(BundleJacobian::entries);
  }

 protected:
  using B = BundleProblem;

  void put_weight(std::size_t observation) {
    const double weight = x_[B::first_weight + observation];
    gradient_[2 * B::block * B::observations + observation] = -2 * weight;
    value_ += 1 - weight * weight;
  }

  BundleJacobian bundle_;
  std::vector<double> x_;
};

/// An observation at a time on a small tape, both of its errors in one sweep.
class BlockSweeps final : public JacobianComputation {
 public:
  using JacobianComputation::JacobianComputation;
  void run() override {
    const auto scope = tape_.activate();
    value_ = 0;
    std::array<Variable<double>, B::block> inputs;
    std::array<Variable<double>, 2> errors;
    for (std::size_t o = 0; o < B::observations; ++o) {
      tape_.clear();
      tape_.input(B::block_of(x_.data(), o), inputs);
      B::reproject(inputs.data(), inputs.data() + B::camera_size, inputs[B::block - 1],
                   bundle_.seen.data() + 2 * o, errors.data());
      adjoints_.reverse(tape_, errors);
      double* const rows = gradient_.data() + 2 * B::block * o;
      for (std::size_t k = 0; k < B::block; ++k) {
        const auto column = adjoints_.of(inputs[k]);
        rows[k] = column[0], rows[B::block + k] = column[1];
      }
      value_ += errors[0].value() + errors[1].value();
      put_weight(o);
    }
  }

 private:
  Tape<double> tape_;
  AdjointVectors<double, 2> adjoints_;
};

/// An observation at a time in forward mode, all of its inputs as directions.
class BlockDuals final : public JacobianComputation {
 public:
  using JacobianComputation::JacobianComputation;
  void run() override {
    using D = Dual<double, 16>;
    value_ = 0;
    std::array<D, B::block> inputs;
    D errors[2];
    for (std::size_t o = 0; o < B::observations; ++o) {
      const auto block = B::block_of(x_.data(), o);
      for (std::size_t k = 0; k < B::block; ++k) inputs[k] = D::input(block[k], k);
      B::reproject(inputs.data(), inputs.data() + B::camera_size, inputs[B::block - 1],
                   bundle_.seen.data() + 2 * o, errors);
      for (std::size_t e = 0; e < 2; ++e) {
        for (std::size_t k = 0; k < B::block; ++k)
          gradient_[(2 * o + e) * B::block + k] = errors[e].tangent(k);
        value_ += errors[e].value();
      }
      put_weight(o);
    }
  }
};

/// All residuals on one tape, and their Jacobian by sweeps for columns that share no row. Its structure is
/// found beforehand, as a solver does once.
class CompressedSweeps final : public JacobianComputation {
 public:
  explicit CompressedSweeps(const BundleJacobian& bundle)
      : JacobianComputation(bundle), inputs_(x_.size()), residuals_(B::residuals) {
    const auto scope = tape_.activate();
    record();
    plan_ = JacobianPlan(sparsity_pattern<double>(tape_, residuals_, inputs_));
  }
  void run() override {
    const auto scope = tape_.activate();
    record();
    jacobian_.resize(plan_.pattern().entry_count());
    compressed_jacobian<double>(tape_, residuals_, inputs_, plan_, jacobian_);
    value_ = 0;
    for (const auto& residual : residuals_) value_ += residual.value();
  }
  void finish() override {
    plan_.pattern().visit([&](std::size_t row, std::size_t column, std::size_t entry) {
      const std::size_t o = row < 2 * B::observations ? row / 2 : row - 2 * B::observations;
      gradient_[place_of(row, o, column)] = jacobian_[entry];
    });
  }

 private:
  void record() {
    tape_.clear();
    tape_.input(x_, inputs_);
    bundle_.residuals_of(inputs_.data(), residuals_.data());
  }
  [[nodiscard]] static std::size_t place_of(std::size_t row, std::size_t o, std::size_t column) {
    if (row >= 2 * B::observations) return 2 * B::block * B::observations + o;
    const std::size_t k = column >= B::first_weight  ? B::block - 1
                          : column >= B::first_point ? B::camera_size + (column - B::first_point) % 3
                                                     : column % B::camera_size;
    return row * B::block + k;
  }

  Tape<double> tape_;
  std::vector<Variable<double>> inputs_, residuals_;
  JacobianPlan plan_;
  std::vector<double> jacobian_;
};
}  // namespace tapestry::benchmarks

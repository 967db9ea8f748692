#pragma once
#include <algorithm>
#include <map>
#include <memory>
#include <oneapi/dnnl/dnnl.hpp>
#include <tapestry/core/error.hpp>
#include <unordered_map>
#include <vector>

namespace tapestry::benchmarks {
/// One primitive of oneDNN with what it works on.
struct Step {
  dnnl::primitive primitive;
  std::unordered_map<int, dnnl::memory> arguments;
};

/// Steps in the order in which they run.
class Plan {
 public:
  explicit Plan(const dnnl::engine& engine) : engine_(engine), stream_(engine) {}

  /// \throws Error for a convolution that oneDNN has only its slow reference for
  void append(const dnnl::primitive& primitive, std::unordered_map<int, dnnl::memory> arguments) {
    if (is_convolution(primitive)) {
      const std::string kernel = kernel_of(primitive);
      if (kernel.starts_with("ref"))
        throw Error(ErrorKind::limit, "oneDNN: a convolution runs by '" + kernel + "'");
      ++kernels_[kernel];
    }
    steps_.push_back({primitive, std::move(arguments)});
  }

  /// The convolutions' kernels by oneDNN's names, and how many each computes.
  [[nodiscard]] const std::map<std::string, std::size_t>& kernels() const { return kernels_; }

  void append_reorder(dnnl::memory from, dnnl::memory to, const dnnl::primitive_attr& attributes = {}) {
    append(dnnl::reorder(dnnl::reorder::primitive_desc(from, to, attributes)),
           {{DNNL_ARG_FROM, from}, {DNNL_ARG_TO, to}});
  }

  void run() {
    for (const Step& step : steps_) step.primitive.execute(stream_, step.arguments);
    stream_.wait();
  }

 private:
  static bool is_convolution(const dnnl::primitive& primitive) {
    return primitive.get_kind() == dnnl::primitive::kind::convolution;
  }
  static std::string kernel_of(const dnnl::primitive& primitive) {
    const char* name = nullptr;
    dnnl_primitive_desc_query(primitive.get_primitive_desc(), dnnl_query_impl_info_str, 0, &name);
    return name == nullptr ? "" : name;
  }

  std::map<std::string, std::size_t> kernels_;
  dnnl::engine engine_;
  dnnl::stream stream_;
  std::vector<Step> steps_;
};

/// An activation or the adjoint of one. Copies share the memory, which goes back to the pool with the last.
struct Value {
  dnnl::memory memory{};
  std::shared_ptr<void> owner{};

  [[nodiscard]] bool is_empty() const { return owner == nullptr; }
  [[nodiscard]] bool is_shared() const { return owner.use_count() > 1; }
};

/// Memory for values whose lifetimes are known before anything runs: what the steps planned so far no longer
/// need is given to the steps that follow.
class Pool {
 public:
  explicit Pool(dnnl::engine engine) : engine_(std::move(engine)), free_(std::make_shared<Free>()) {}

  /// The smallest free piece that is large enough, or a new one.
  [[nodiscard]] Value take(const dnnl::memory::desc& description) {
    const std::size_t bytes = description.get_size();
    auto best = free_->end();
    for (auto piece = free_->begin(); piece != free_->end(); ++piece) {
      const std::size_t size = piece->get_desc().get_size();
      if (size >= bytes && (best == free_->end() || size < best->get_desc().get_size())) best = piece;
    }
    dnnl::memory piece;
    if (best != free_->end()) {
      piece = *best;
      free_->erase(best);
    } else {
      const auto count = static_cast<dnnl::memory::dim>(bytes);
      piece = dnnl::memory({{count}, dnnl::memory::data_type::u8, dnnl::memory::format_tag::a}, engine_);
    }
    Value value{dnnl::memory(description, engine_, piece.get_data_handle())};
    value.owner = std::shared_ptr<void>(piece.get_data_handle(),
                                        [free = free_, piece](void*) { free->push_back(piece); });
    return value;
  }

 private:
  using Free = std::vector<dnnl::memory>;
  dnnl::engine engine_;
  std::shared_ptr<Free> free_;
};
}  // namespace tapestry::benchmarks

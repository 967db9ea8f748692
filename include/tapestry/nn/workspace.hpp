#pragma once
#include <cstddef>
#include <tapestry/nn/buffer.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn {

/// Memory that layers hand to one another, kept between passes.
template <class T>
class Workspace {
 public:
  /// The smallest free buffer that is large enough, else the largest one, grown.
  [[nodiscard]] Buffer<T> take(std::size_t count) {
    std::size_t best = free_.size();
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (best == free_.size()) {
        best = i;
        continue;
      }
      const bool fits = free_[i].capacity() >= count;
      const bool best_fits = free_[best].capacity() >= count;
      const bool is_smaller = free_[i].capacity() < free_[best].capacity();
      if (fits ? !best_fits || is_smaller : !best_fits && !is_smaller) best = i;
    }
    Buffer<T> buffer;
    if (best < free_.size()) {
      buffer = std::move(free_[best]);
      free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(best));
    }
    buffer.resize(count);
    return buffer;
  }

  void give(Buffer<T>&& buffer) {
    if (buffer.capacity() > 0) free_.push_back(std::move(buffer));
    buffer = Buffer<T>();
  }

 private:
  std::vector<Buffer<T>> free_;
};

}  // namespace tapestry::nn

#pragma once
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace tapestry {
/// Objects whose memory is used again and again, by steps that follow one another and by threads side by
/// side. A copy of a pool shares its objects.
template <class Object>
class Pool {
 public:
  /// An object that nobody else holds, as its last holder left it. It returns to the pool when it is
  /// released, even if the pool is gone. May be called by several threads at once.
  [[nodiscard]] std::shared_ptr<Object> take() {
    return {idle_->take().release(),
            [idle = idle_](Object* object) { idle->give_back(std::unique_ptr<Object>(object)); }};
  }

  /// Objects made so far: as many as were held at once.
  [[nodiscard]] std::size_t size() const { return idle_->count(); }

 private:
  class Idle {
   public:
    std::unique_ptr<Object> take() {
      const std::lock_guard lock(mutex_);
      if (objects_.empty()) {
        objects_.reserve(++count_);  // so that no object is thrown away
        return std::make_unique<Object>();
      }
      auto object = std::move(objects_.back());
      objects_.pop_back();
      return object;
    }
    void give_back(std::unique_ptr<Object> object) {
      const std::lock_guard lock(mutex_);
      objects_.push_back(std::move(object));
    }
    std::size_t count() {
      const std::lock_guard lock(mutex_);
      return count_;
    }

   private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<Object>> objects_;
    std::size_t count_ = 0;
  };

  std::shared_ptr<Idle> idle_ = std::make_shared<Idle>();
};
}  // namespace tapestry

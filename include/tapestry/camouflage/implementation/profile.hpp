#pragma once
#include <chrono>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <utility>

namespace tapestry::camouflage {

template <class T>
void StageClock<T>::end_of(Stage forward, Stage reverse) {
  shared_->count(forward);
  mark(reverse);
}

template <class T>
void StageClock<T>::mark(Stage before) {
  if (!is_swept_) return;
  record_mark<T>([shared = shared_, before] {
    shared->count(shared->swept);
    shared->swept = before;
  });
}

template class StageClock<float>;
template class StageClock<double>;

}  // namespace tapestry::camouflage

#pragma once
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tapestry/camouflage/kept_layers.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <vector>

namespace tapestry::camouflage {

template <class T>
std::vector<detect::KeptPicture<T>*> KeptLayers<T>::of(const detect::Detector<T>& detector, Views views,
                                                       double least_share) {
  std::vector<detect::KeptPicture<T>*> pictures;
  for (const auto& view : views) {
    const auto [found, is_new] = views_.try_emplace(view->name);
    Kept& kept = found->second;
    if (is_new) kept.share = detector.share_kept(view->window);
    if (is_new && !is_full_ && kept.share >= least_share) kept.picture.emplace(view->window);
    pictures.push_back(kept.picture && kept.picture->window() == view->window ? &*kept.picture : nullptr);
  }
  if (std::ranges::count(pictures, nullptr) == std::ssize(pictures)) pictures.clear();
  return pictures;
}

template <class T>
void KeptLayers<T>::limit_to(std::size_t bytes, Views views) {
  if (is_full_ || this->bytes() <= bytes) return;
  for (const auto& view : views) views_[view->name].picture.reset();
  is_full_ = true;
}

template <class T>
std::size_t KeptLayers<T>::bytes() const {
  std::size_t sum = 0;
  for (const auto& [name, kept] : views_) sum += kept.picture ? kept.picture->bytes() : 0;
  return sum;
}

template <class T>
std::size_t KeptLayers<T>::kept_count() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(views_, [](const auto& entry) { return entry.second.picture.has_value(); }));
}

template <class T>
double KeptLayers<T>::share() const {
  double sum = 0;
  for (const auto& [name, kept] : views_) sum += kept.picture ? kept.share : 0;
  return views_.empty() ? 0 : sum / static_cast<double>(views_.size());
}

template class KeptLayers<float>;
template class KeptLayers<double>;

}  // namespace tapestry::camouflage

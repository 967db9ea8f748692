#pragma once
#include <tapestry/detect/pass.hpp>

namespace tapestry::detect {

template <class T>
Pass<T>::Pass() = default;

template <class T>
Pass<T>::Pass(Pass&&) noexcept = default;

template <class T>
Pass<T>& Pass<T>::operator=(Pass&&) noexcept = default;

template <class T>
Pass<T>::~Pass() = default;

template struct Pass<float>;
template struct Pass<double>;

}  // namespace tapestry::detect

#pragma once
#include <cstddef>
#include <tapestry/detect/box_overlap.hpp>

namespace tapestry::evaluate {

/// An object that is in a picture.
struct TruthBox {
  std::size_t picture = 0;
  std::size_t class_index = 0;
  detect::Box box{};        ///< pixels of the picture, as all boxes here
  double area = 0;          ///< of the object, square pixels: that of its outline where it is known
  bool is_crowd = false;    ///< stands for many objects: ignored, however often it is found
  bool is_ignored = false;  ///< counts neither when it is found, once, nor when it is not
};

/// An object that a detector says is in a picture.
struct ScoredBox {
  std::size_t picture = 0;
  std::size_t class_index = 0;
  detect::Box box{};
  double confidence = 0;
};

}  // namespace tapestry::evaluate

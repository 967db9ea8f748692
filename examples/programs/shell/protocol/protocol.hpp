#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/evaluate/protocol_cells.hpp>
#include <tapestry/evaluate/views.hpp>
#include <utility>
#include <vector>

#include "drawing.hpp"

namespace tapestry::shell {

/// What is done to every picture of a frame, whatever the texture.
struct FrameChange {
  double hidden_share = 0;  ///< of the car's silhouette
  std::function<void(Array<float, 3>&)> apply;
};

/// The pictures without the car, last among the textures of a protocol that changes pictures: what is found
/// there is no car.
inline constexpr const char* no_car_name = "no car";

/// What a protocol found out.
struct ProtocolResult {
  std::vector<std::string> textures;  ///< names; the clean one first, then the camouflage, if there is one
  bool has_camouflage = false;
  std::vector<evaluate::Cell> cells;  ///< of the table, row by row
  evaluate::Cell whole;               ///< all frames

  /// Whether a texture can hide the car, which the clean one and none cannot.
  [[nodiscard]] bool is_attack(std::size_t texture) const {
    return texture > 0 && textures[texture] != no_car_name;
  }
  /// The textures that figures show: clean, the camouflage, the noise matched to it, and no car.
  [[nodiscard]] std::vector<std::size_t> shown_textures() const {
    std::vector<std::size_t> shown{0};
    if (has_camouflage) shown.insert(shown.end(), {1, 2});
    if (textures.back() == no_car_name) shown.push_back(textures.size() - 1);
    return shown;
  }
};

/// A set of renders that a table sums up. A further protocol is a header that makes one of these, and its
/// line in protocols.hpp.
struct Protocol {
  std::string name;
  std::string title;
  evaluate::ProtocolTable table;
  std::vector<evaluate::ProtocolFrame> frames;
  std::vector<std::string> notes{};  ///< sentences under the table
  /// Nothing to leave the frame out; an empty function leaves pictures as they are.
  std::function<std::optional<FrameChange>(const camouflage::View<float>&, std::size_t frame)> change{};
  std::function<Figure(const Protocol&, const ProtocolResult&)> figure{};
};

}  // namespace tapestry::shell

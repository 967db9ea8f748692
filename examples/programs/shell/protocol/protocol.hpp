#pragma once
#include <tapestry/evaluate/protocol_cells.hpp>
#include "../../../scenes/vehicle.hpp"
#include "drawing.hpp"

namespace tapestry::shell {
/// Change to every picture of a frame, for all textures.
struct FrameChange {
  double hidden_share = 0;  ///< of the car's silhouette
  std::function<void(Array<float, 3>&)> apply;
};

/// The confidence thresholds to list P@0.5 at, besides --confidence.
inline const std::vector<double> swept_thresholds{0.05, 0.1, 0.25, 0.5, 0.75};

/// Share of a detector's attention that lies on the car with a texture.
struct AttentionShare {
  double mean = 0;
  evaluate::PairedDifference lost{};  ///< clean minus this
};

/// Frames that are summarised together: all of them, or one detector's.
struct ProtocolSection {
  std::string name;
  evaluate::Cell cell{};
  std::optional<evaluate::Effect> effect{};  ///< of the camouflage beyond the noise matched to it
  std::vector<std::vector<evaluate::DetectionRate>> sweep{};  ///< [texture][threshold]
  std::vector<AttentionShare> attention{};                    ///< [texture]; empty without heat maps
  double car_share = 0;                                       ///< of the pictures, mean
};

struct ProtocolResult {
  std::vector<std::string> textures;  ///< names; the clean one first, then the camouflage, if there is one
  bool has_camouflage = false;
  std::optional<double> noise_in_place{};  ///< see evaluate::noise_in_place()
  bool has_bare = false;                   ///< whether the last texture is unpainted, see Protocol::bare_name
  std::vector<evaluate::Cell> cells;       ///< of the table, row by row
  std::vector<ProtocolSection> sections;
  std::vector<std::vector<std::string>> class_names{};  ///< of each detector, empty where it has none
  /// The first section's effect divided by the second's, see Protocol::parts.
  std::optional<evaluate::PairedRatio> effect_kept{};
  std::vector<std::pair<std::string, std::string>>
      pictures{};  ///< descriptions, and the bytes of their PNG files

  [[nodiscard]] const std::vector<std::string>& names_of(std::size_t section) const {
    return class_names.at(std::min(section, class_names.size() - 1));
  }

  [[nodiscard]] bool is_bare(std::size_t texture) const { return has_bare && texture + 1 == textures.size(); }
  /// Whether a texture can hide the car; the clean one and the unpainted picture cannot.
  [[nodiscard]] bool is_attack(std::size_t texture) const { return texture > 0 && !is_bare(texture); }
  /// The textures that figures show: clean, the camouflage, the noise matched to it, and unpainted.
  [[nodiscard]] std::vector<std::size_t> shown_textures() const {
    std::vector<std::size_t> shown{0};
    if (has_camouflage) shown.insert(shown.end(), {1, 2});
    if (has_bare) shown.push_back(textures.size() - 1);
    return shown;
  }
  [[nodiscard]] std::string shown_names() const {
    return listed(shown_textures(), [&](std::size_t texture) { return textures[texture]; });
  }
};

/// Subject of a protocol: detectors, frames and settings that it is made for.
struct ProtocolSubject {
  std::vector<std::string> detectors;  ///< names
  std::size_t frame_count = 0;         ///< of photographs
};

/// Rows of a table that are summarised together.
struct ProtocolPart {
  std::string name;
  std::size_t first_row = 0;
  std::size_t row_count = 0;

  [[nodiscard]] bool holds(std::size_t row) const { return row >= first_row && row - first_row < row_count; }
};

/// A set of pictures that a table summarises. To add a protocol, write a header that makes one of these, and
/// add its line to protocols.hpp.
struct Protocol {
  std::string name;
  std::string title;
  evaluate::ProtocolTable table;
  /// Renders, or photographs. Photographs are listed once for each column, one detector after another; only
  /// their places in the table are used.
  std::vector<evaluate::ProtocolFrame> frames;
  bool on_photographs = false;  ///< columns are then detectors, and are not summed up
  bool maps_attention = false;  ///< whether heat maps are computed
  /// Parts of renders that are summarised separately; empty: all frames together. The worst cell is taken
  /// from the first part, and the report states the share of the second part's effect that the first part
  /// keeps.
  std::vector<ProtocolPart> parts{};
  std::string bare_name{};           ///< name of unpainted pictures, which are measured last; empty: none
  std::vector<std::string> notes{};  ///< sentences under the table
  /// Returns nothing to leave a frame out. An empty function leaves pictures unchanged.
  std::function<std::optional<FrameChange>(const camouflage::View<float>&, std::size_t frame)> change{};
  /// The street around the car in a frame, in metres; if empty, the car is before a plain background.
  std::function<io::Frame(const scenes::Vehicle&, std::size_t frame, std::size_t size_px)> street{};
  /// Number of a frame's view. Frames with the same number share one view, which is made once; if empty, no
  /// frames share a view.
  std::function<std::size_t(std::size_t frame)> view_of{};
  /// The picture of a frame with a paint, and the place of the car in it; if empty, taken from the view.
  std::function<evaluate::Photograph(const camouflage::View<float>&, std::size_t frame,
                                     const camouflage::Paint<float>&)>
      photograph{};
  std::function<Figure(const Protocol&, const ProtocolResult&)> figure{};
};
}  // namespace tapestry::shell

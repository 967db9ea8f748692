#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/io/frame_file.hpp>
#include "scene.hpp"

namespace tapestry::scenes {
/// Draws scenes until the car is in the picture and enough of it shows.
/// \param make   gives a scene for random numbers
/// \param least, most  share of the car's samples that nothing hides, from least to below most
/// \throws DomainError if of a thousand scenes none will do
[[nodiscard]] io::Frame make_frame(Random& random, const std::function<Scene(Random&)>& make, double least,
                                   double most, std::size_t height, std::size_t width);

/// The same, within a number of scenes; nothing if none fits.
/// \param shows_car  whether the picture shows the car; if not, the background with the car's shadow
[[nodiscard]] std::optional<io::Frame> find_frame(Random& random, const std::function<Scene(Random&)>& make,
                                                  double least, double most, std::size_t height,
                                                  std::size_t width, bool shows_car, std::size_t attempts);

/// Draws street scenes until the car is in the picture and at least 60 % of it shows, 97 % in scenes without
/// occluders.
[[nodiscard]] io::Frame make_frame(Random& random, const SceneOptions& options, std::size_t size);

/// The bundled street scenes: views of the sedan spread evenly around it. `seed` and the stream decide
/// everything, so a frame can be drawn again instead of being stored.
struct DrawnFrames {
  enum class Stream : std::uint64_t { train = 1, test = 2 };

  std::size_t count;
  Stream stream;
  std::uint64_t seed = 1;
  std::size_t size = 256;  ///< pixels along a side

  [[nodiscard]] io::Frame operator()(std::size_t index) const;
};
}  // namespace tapestry::scenes

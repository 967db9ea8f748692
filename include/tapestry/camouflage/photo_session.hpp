#pragma once
#include <tapestry/camouflage/view.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/loss/prediction.hpp>

namespace tapestry::camouflage {
/// One photograph of a view: the transformations of its picture, and the car's place in it.
struct Shot {
  image::TransformationChain chain;
  detect::Box target;  ///< in pixels of the network's input
};

/// A print of a paint, if it was printed, and photographs of it, one for each of some views.
struct PhotoSession {
  std::optional<image::ColourChange> print;
  std::vector<Shot> shots;
};

/// Draws a photograph of a view, the same for the same random numbers. The camera is held still if its motion
/// would lose half of the car's box or more from the picture.
///
/// \param is_smooth  see image::draw_chain()
template <std::floating_point T>
[[nodiscard]] Shot draw_shot(const View<T>& view, const image::Conditions& conditions, Random random,
                             bool is_smooth);

/// Draws a print of a paint and a photograph of each view.
template <std::floating_point T>
[[nodiscard]] PhotoSession draw_session(ViewSpan<T> views, const image::Conditions& conditions, Random random,
                                        bool is_smooth);

/// Boxes of the car in the pictures of some views, or in their photographs if there is a session.
template <std::floating_point T>
[[nodiscard]] std::vector<loss::Target> targets_of(ViewSpan<T> views, const PhotoSession* session,
                                                   std::size_t class_index);

/// Photographs of a batch of pictures on the tape, [N, H, W, 3]: image::transformed() by the shots' chains.
/// Without a session they are returned unchanged.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> photographed(const ArrayVariable<T, 4>& pictures,
                                               const PhotoSession* session);
}  // namespace tapestry::camouflage

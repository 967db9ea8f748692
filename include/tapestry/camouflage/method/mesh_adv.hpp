#pragma once
#include <concepts>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

/// Texture and shape: the whole painted body, each texel for itself, and an offset of every position of the
/// car, painted or not, of at most a hundredth of its length along each axis. Both start and step together.
///
/// Source: Xiao et al., "MeshAdv: Adversarial Meshes for Visual Recognition" (CVPR 2019). Faithful: texture
/// and shape by the gradient of a rasteriser over several views, Adam, and the Laplacian loss of
/// displacements, see shape_roughness(). Simplified: the mean over edges instead of the sum, with a weight of
/// ours; smoothness of the texture is the objective's, not total variation; offsets are bounded, which the
/// paper leaves to its loss. Better than its source: the gradient is that of the picture, outlines included,
/// where the paper takes Neural Mesh Renderer's. In photographs the car is cut off where the frame's mask
/// ends, so that it cannot grow into what was beside it, see redrawn(); its target box stays that of the car
/// as it is.
///
/// \throws as shape_parameter()
template <std::floating_point T>
[[nodiscard]] Method<T> mesh_adv(const raster::PaintedMesh& car);

}  // namespace tapestry::camouflage

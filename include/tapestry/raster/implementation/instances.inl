// Instances for TAPESTRY_SCALAR; implementation.hpp and implementation_double.hpp include this file last.
#ifndef TAPESTRY_SCALAR  // an editor reads this file alone
#include <tapestry/raster/implementation.hpp>
#define TAPESTRY_SCALAR double
#endif

namespace tapestry::raster {
template ArrayVariable<TAPESTRY_SCALAR, 2> silhouette<TAPESTRY_SCALAR>(
    const geometry::Mesh&, const geometry::Camera&, std::size_t, std::size_t,
    const ArrayVariable<TAPESTRY_SCALAR, 2>&, const ArrayVariable<TAPESTRY_SCALAR, 1>&, std::size_t,
    std::shared_ptr<const MeshEdges> edges);
template decltype(barycentrics<TAPESTRY_SCALAR>) barycentrics<TAPESTRY_SCALAR>;
template decltype(barycentrics_adjoint<TAPESTRY_SCALAR>) barycentrics_adjoint<TAPESTRY_SCALAR>;
template decltype(interpolate_adjoint<TAPESTRY_SCALAR>) interpolate_adjoint<TAPESTRY_SCALAR>;
template decltype(antialias_adjoint<TAPESTRY_SCALAR>) antialias_adjoint<TAPESTRY_SCALAR>;
template decltype(rasterise<TAPESTRY_SCALAR>) rasterise<TAPESTRY_SCALAR>;
template decltype(texture_coordinates<TAPESTRY_SCALAR>) texture_coordinates<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 3> interpolate<TAPESTRY_SCALAR>(const PixelFaces&,
                                                                const Array<TAPESTRY_SCALAR, 3>&,
                                                                const Array<TAPESTRY_SCALAR, 2>&,
                                                                const std::vector<geometry::Corners>&);
template Array<TAPESTRY_SCALAR, 3> antialias<TAPESTRY_SCALAR>(const PixelFaces&,
                                                              const Array<TAPESTRY_SCALAR, 3>&);
template ArrayVariable<TAPESTRY_SCALAR, 3> interpolate<TAPESTRY_SCALAR>(
    const Rasterised<TAPESTRY_SCALAR>&, const ArrayVariable<TAPESTRY_SCALAR, 2>&,
    const std::vector<geometry::Corners>&);
template ArrayVariable<TAPESTRY_SCALAR, 3> antialias<TAPESTRY_SCALAR>(
    const Rasterised<TAPESTRY_SCALAR>&, const ArrayVariable<TAPESTRY_SCALAR, 3>&);
template decltype(look_up_adjoint<TAPESTRY_SCALAR>) look_up_adjoint<TAPESTRY_SCALAR>;
template Array<TAPESTRY_SCALAR, 3> look_up<TAPESTRY_SCALAR>(const Array<TAPESTRY_SCALAR, 3>&,
                                                            const Array<TAPESTRY_SCALAR, 3>&);
template ArrayVariable<TAPESTRY_SCALAR, 3> look_up<TAPESTRY_SCALAR>(const ArrayVariable<TAPESTRY_SCALAR, 3>&,
                                                                    const ArrayVariable<TAPESTRY_SCALAR, 3>&);
template decltype(with_unused_filled<TAPESTRY_SCALAR>) with_unused_filled<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 2> stored_texels<TAPESTRY_SCALAR>(
    const std::shared_ptr<const MipPyramid>&, const ArrayVariable<TAPESTRY_SCALAR, 2>&, image::ColourSpace);
template decltype(used_texels<TAPESTRY_SCALAR>) used_texels<TAPESTRY_SCALAR>;
template decltype(used_texels_or_all<TAPESTRY_SCALAR>) used_texels_or_all<TAPESTRY_SCALAR>;
template decltype(bake_atlas<TAPESTRY_SCALAR>) bake_atlas<TAPESTRY_SCALAR>;
template decltype(bake_cube<TAPESTRY_SCALAR>) bake_cube<TAPESTRY_SCALAR>;
template decltype(texture_operator<TAPESTRY_SCALAR, Light>) texture_operator<TAPESTRY_SCALAR, Light>;
template decltype(texture_operator<TAPESTRY_SCALAR, Unlit>) texture_operator<TAPESTRY_SCALAR, Unlit>;
template Array<TAPESTRY_SCALAR, 3> render<TAPESTRY_SCALAR>(const TextureOperator<TAPESTRY_SCALAR>&,
                                                           const Array<TAPESTRY_SCALAR, 2>&);
template decltype(render_adjoint<TAPESTRY_SCALAR>) render_adjoint<TAPESTRY_SCALAR>;
template decltype(compacted<TAPESTRY_SCALAR>) compacted<TAPESTRY_SCALAR>;
template std::vector<ArrayVariable<TAPESTRY_SCALAR, 3>> render<TAPESTRY_SCALAR>(
    const std::vector<std::shared_ptr<const CompactOperator<TAPESTRY_SCALAR>>>&,
    const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template ArrayVariable<TAPESTRY_SCALAR, 3> render<TAPESTRY_SCALAR>(const TextureOperator<TAPESTRY_SCALAR>&,
                                                                   const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template decltype(silhouette_adjoint<TAPESTRY_SCALAR>) silhouette_adjoint<TAPESTRY_SCALAR>;
template decltype(detail::record_coverage<TAPESTRY_SCALAR>) detail::record_coverage<TAPESTRY_SCALAR>;
}  // namespace tapestry::raster

// Instances for TAPESTRY_SCALAR; implementation.hpp includes this file behind the bodies, a test for double.
#ifndef TAPESTRY_SCALAR  // an editor reads this file alone
#include <tapestry/camouflage/implementation.hpp>
#define TAPESTRY_SCALAR double
#endif

namespace tapestry::camouflage::detail {
template decltype(interior_of<TAPESTRY_SCALAR>) interior_of<TAPESTRY_SCALAR>;
}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {
template void require_sound<TAPESTRY_SCALAR>(const Method<TAPESTRY_SCALAR>& method);
template decltype(painted_texels<TAPESTRY_SCALAR>) painted_texels<TAPESTRY_SCALAR>;
template decltype(first_parameter<TAPESTRY_SCALAR>) first_parameter<TAPESTRY_SCALAR>;
template decltype(texture_rows<TAPESTRY_SCALAR>) texture_rows<TAPESTRY_SCALAR>;
template ArrayVariable<TAPESTRY_SCALAR, 2> method_colours<TAPESTRY_SCALAR>(
    const Method<TAPESTRY_SCALAR>&, const ArrayVariable<TAPESTRY_SCALAR, 2>&);
template ArrayVariable<TAPESTRY_SCALAR, 2> printed<TAPESTRY_SCALAR>(const Method<TAPESTRY_SCALAR>&,
                                                                    const ArrayVariable<TAPESTRY_SCALAR, 2>&,
                                                                    const image::ColourChange&);
template decltype(paint_panels<TAPESTRY_SCALAR>) paint_panels<TAPESTRY_SCALAR>;
template class KeptLayers<TAPESTRY_SCALAR>;
template class Ensemble<TAPESTRY_SCALAR>;
template class Objective<TAPESTRY_SCALAR>;
template decltype(without_paint<TAPESTRY_SCALAR>) without_paint<TAPESTRY_SCALAR>;
template void require_sound<TAPESTRY_SCALAR>(const char* operation, const Paint<TAPESTRY_SCALAR>&);
template Array<TAPESTRY_SCALAR, 2> printed<TAPESTRY_SCALAR>(const Paint<TAPESTRY_SCALAR>&,
                                                            const image::ColourChange&);
template decltype(own_colours<TAPESTRY_SCALAR>) own_colours<TAPESTRY_SCALAR>;
template decltype(atlas_of<TAPESTRY_SCALAR>) atlas_of<TAPESTRY_SCALAR>;
template decltype(parameter_of_colours<TAPESTRY_SCALAR>) parameter_of_colours<TAPESTRY_SCALAR>;
template decltype(random_colours<TAPESTRY_SCALAR>) random_colours<TAPESTRY_SCALAR>;
template decltype(solid_colours<TAPESTRY_SCALAR>) solid_colours<TAPESTRY_SCALAR>;
template decltype(targets_of<TAPESTRY_SCALAR>) targets_of<TAPESTRY_SCALAR>;
template decltype(photographed<TAPESTRY_SCALAR>) photographed<TAPESTRY_SCALAR>;
template decltype(draw_shot<TAPESTRY_SCALAR>) draw_shot<TAPESTRY_SCALAR>;
template decltype(draw_session<TAPESTRY_SCALAR>) draw_session<TAPESTRY_SCALAR>;
template decltype(drawn_texels<TAPESTRY_SCALAR>) drawn_texels<TAPESTRY_SCALAR>;
template decltype(drawn_views<TAPESTRY_SCALAR>) drawn_views<TAPESTRY_SCALAR>;
template decltype(laid_over<TAPESTRY_SCALAR>) laid_over<TAPESTRY_SCALAR>;
template decltype(smoothness_of<TAPESTRY_SCALAR>) smoothness_of<TAPESTRY_SCALAR>;
template decltype(write_checkpoint<TAPESTRY_SCALAR>) write_checkpoint<TAPESTRY_SCALAR>;
template decltype(read_checkpoint<TAPESTRY_SCALAR>) read_checkpoint<TAPESTRY_SCALAR>;
template decltype(shape_steps<TAPESTRY_SCALAR>) shape_steps<TAPESTRY_SCALAR>;
template decltype(shape_positions<TAPESTRY_SCALAR>) shape_positions<TAPESTRY_SCALAR>;
template decltype(shape_offsets<TAPESTRY_SCALAR>) shape_offsets<TAPESTRY_SCALAR>;
template decltype(reshaped<TAPESTRY_SCALAR>) reshaped<TAPESTRY_SCALAR>;
template decltype(redrawn<TAPESTRY_SCALAR>) redrawn<TAPESTRY_SCALAR>;
template class Training<TAPESTRY_SCALAR>;
template class StageClock<TAPESTRY_SCALAR>;
template decltype(sight_of<TAPESTRY_SCALAR>) sight_of<TAPESTRY_SCALAR>;
template decltype(make_view<TAPESTRY_SCALAR>) make_view<TAPESTRY_SCALAR>;
template decltype(picture_of<TAPESTRY_SCALAR>) picture_of<TAPESTRY_SCALAR>;
template decltype(texels_of<TAPESTRY_SCALAR>) texels_of<TAPESTRY_SCALAR>;
template decltype(picture_of_texels<TAPESTRY_SCALAR>) picture_of_texels<TAPESTRY_SCALAR>;
template decltype(view_bytes<TAPESTRY_SCALAR>) view_bytes<TAPESTRY_SCALAR>;
template class ViewStore<TAPESTRY_SCALAR>;
}  // namespace tapestry::camouflage

// The functions and classes of this room, for the scalar TAPESTRY_SCALAR; implementation.hpp and
// implementation_double.hpp include this file behind the bodies.

namespace tapestry::io {
template decltype(read_darknet_model<TAPESTRY_SCALAR>) read_darknet_model<TAPESTRY_SCALAR>;
template decltype(darknet_model<TAPESTRY_SCALAR>) darknet_model<TAPESTRY_SCALAR>;
template decltype(read_classifier<TAPESTRY_SCALAR>) read_classifier<TAPESTRY_SCALAR>;
template void write_image<TAPESTRY_SCALAR>(const std::string& path, const Array<TAPESTRY_SCALAR, 3>& image);
template std::string png_file<TAPESTRY_SCALAR>(const std::string& path,
                                               const Array<TAPESTRY_SCALAR, 3>& image);
template decltype(write_mask<TAPESTRY_SCALAR>) write_mask<TAPESTRY_SCALAR>;
template decltype(write_gradient<TAPESTRY_SCALAR>) write_gradient<TAPESTRY_SCALAR>;
template decltype(write_painted_obj<TAPESTRY_SCALAR>) write_painted_obj<TAPESTRY_SCALAR>;
template decltype(write_painted_glb<TAPESTRY_SCALAR>) write_painted_glb<TAPESTRY_SCALAR>;
template decltype(read_detector<TAPESTRY_SCALAR>) read_detector<TAPESTRY_SCALAR>;
template decltype(read_input<TAPESTRY_SCALAR>) read_input<TAPESTRY_SCALAR>;
}  // namespace tapestry::io

namespace tapestry::io::detail {
template decltype(levels<TAPESTRY_SCALAR>) levels<TAPESTRY_SCALAR>;
template decltype(append_number<TAPESTRY_SCALAR>) append_number<TAPESTRY_SCALAR>;
template decltype(with_gutters_filled<TAPESTRY_SCALAR>) with_gutters_filled<TAPESTRY_SCALAR>;
}  // namespace tapestry::io::detail

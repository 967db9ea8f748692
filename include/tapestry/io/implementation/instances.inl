// Instances for TAPESTRY_SCALAR; implementation.hpp and implementation_double.hpp include this file last.
#ifndef TAPESTRY_SCALAR  // an editor reads this file alone
#include <tapestry/io/implementation.hpp>
#define TAPESTRY_SCALAR double
#endif

namespace tapestry::io {
template decltype(read_darknet_model<TAPESTRY_SCALAR>) read_darknet_model<TAPESTRY_SCALAR>;
template decltype(darknet_model<TAPESTRY_SCALAR>) darknet_model<TAPESTRY_SCALAR>;
template decltype(read_classifier<TAPESTRY_SCALAR>) read_classifier<TAPESTRY_SCALAR>;
template void write_image<TAPESTRY_SCALAR>(const std::string&, const Array<TAPESTRY_SCALAR, 3>&);
template std::string png_file<TAPESTRY_SCALAR>(const std::string&, const Array<TAPESTRY_SCALAR, 3>&);
template decltype(write_mask<TAPESTRY_SCALAR>) write_mask<TAPESTRY_SCALAR>;
template decltype(write_gradient<TAPESTRY_SCALAR>) write_gradient<TAPESTRY_SCALAR>;
template decltype(write_painted_obj<TAPESTRY_SCALAR>) write_painted_obj<TAPESTRY_SCALAR>;
template decltype(write_painted_glb<TAPESTRY_SCALAR>) write_painted_glb<TAPESTRY_SCALAR>;
template decltype(read_detector<TAPESTRY_SCALAR>) read_detector<TAPESTRY_SCALAR>;
template decltype(read_input<TAPESTRY_SCALAR>) read_input<TAPESTRY_SCALAR>;
template decltype(detail::levels<TAPESTRY_SCALAR>) detail::levels<TAPESTRY_SCALAR>;
template decltype(detail::append_number<TAPESTRY_SCALAR>) detail::append_number<TAPESTRY_SCALAR>;
template decltype(detail::with_gutters_filled<TAPESTRY_SCALAR>) detail::with_gutters_filled<TAPESTRY_SCALAR>;
}  // namespace tapestry::io

#pragma once
/// \file
/// The compiled part of io/ for float, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/io/implementation/png.hpp>  // first, for it must see stb before anyone else

#include <tapestry/io/implementation/atomic_file.hpp>
#include <tapestry/io/implementation/byte_image_file.hpp>
#include <tapestry/io/implementation/darknet/model_file.hpp>
#include <tapestry/io/implementation/darknet/network_config.hpp>
#include <tapestry/io/implementation/darknet/weight_file.hpp>
#include <tapestry/io/implementation/detector_description.hpp>
#include <tapestry/io/implementation/detector_file.hpp>
#include <tapestry/io/implementation/exported_names.hpp>
#include <tapestry/io/implementation/file_source.hpp>
#include <tapestry/io/implementation/frame_file.hpp>
#include <tapestry/io/implementation/glb.hpp>
#include <tapestry/io/implementation/image_file.hpp>
#include <tapestry/io/implementation/jpeg.hpp>
#include <tapestry/io/implementation/jpeg_file.hpp>
#include <tapestry/io/implementation/json.hpp>
#include <tapestry/io/implementation/mesh_writers.hpp>
#include <tapestry/io/implementation/mtl_file.hpp>
#include <tapestry/io/implementation/npy.hpp>
#include <tapestry/io/implementation/obj_file.hpp>
#include <tapestry/io/implementation/onnx/onnx_file.hpp>
#include <tapestry/io/implementation/onnx/onnx_writer.hpp>
#include <tapestry/io/implementation/plain_mesh_writers.hpp>
#include <tapestry/io/implementation/read_detector.hpp>
#include <tapestry/io/implementation/text_lists.hpp>
/// \cond
#define TAPESTRY_SCALAR float
#include <tapestry/io/implementation/instances.inl>
#undef TAPESTRY_SCALAR
/// \endcond

#pragma once
/// \file
/// The compiled parts of the library. Exactly one .cpp of a program that reads networks, or reads or writes
/// pictures, .safetensors, .glb, or the .json files of detectors or COCO, includes this header. Where several
/// .cpp use networks or render, define TAPESTRY_EXTERN_KERNELS for all of them: the kernels and the operators
/// of networks, which take a compiler longest, are then compiled here alone and not in each.
#include <tapestry/io/implementation/png.hpp>  // first, for it must see stb before anyone else

#include <tapestry/io/implementation/coco.hpp>
#include <tapestry/io/implementation/detector_description.hpp>
#include <tapestry/io/implementation/glb.hpp>
#include <tapestry/io/implementation/jpeg.hpp>
#include <tapestry/io/implementation/safetensors.hpp>

#if defined(TAPESTRY_EXTERN_KERNELS)
#include <tapestry/nn/network/operator_definitions.hpp>
#include <tapestry/nn/vector_kernel_definitions.hpp>
#include <tapestry/raster/raster_kernel_definitions.hpp>

namespace tapestry::nn {
template Kernels<float> kernels_of<float>(InstructionSet);
template Kernels<double> kernels_of<double>(InstructionSet);
template const OperatorTable<float>& operators<float>();
template const OperatorTable<double>& operators<double>();
}  // namespace tapestry::nn
#endif

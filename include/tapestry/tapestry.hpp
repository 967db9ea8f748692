#pragma once
/// \mainpage Tapestry
/// A reverse-mode tape, and on it everything that a full-coverage camouflage optimisation needs: one gradient
/// runs from a detector's output back to the paint on a car. This header includes all of it but
/// io/implementation.hpp, which belongs in one source file of a program; including only what a file needs
/// compiles faster.
///
/// The layers, a header of one using only its own folder and those before it:
///   core                          arrays, checks, errors, files, random numbers, threads
///   autodiff                      the tape, variables, and how an operation joins it
///   geometry, image, nn, optim    meshes and cameras; pictures; network layers; Adam
///   raster, detect                mesh to picture; picture to boxes
///   loss, io                      terms of the objective; files in and out
///   camouflage, evaluate          parameters, objective and training; rates that judge an attack
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/expression.hpp>
#include <tapestry/autodiff/flat_stack.hpp>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/gradient_check.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/autodiff/scalar_functions.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/autodiff/tape_state.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/camouflage/checkpoint.hpp>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/camouflage/own_colours.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/camouflage/training.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/array_concepts.hpp>
#include <tapestry/core/atomic_file.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/file_source.hpp>
#include <tapestry/core/huge_pages.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/core/nearest_word.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/batch_norm_folding.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/box_grid.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/decode_family.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/detect/network.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/detect/weight_file.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/carla_pose.hpp>
#include <tapestry/geometry/face_selection.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/image/composite.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/image/planes.hpp>
#include <tapestry/image/resize.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/detector_metadata.hpp>
#include <tapestry/io/face_list_file.hpp>
#include <tapestry/io/float_formats.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/json_reader.hpp>
#include <tapestry/io/loaded_mesh.hpp>
#include <tapestry/io/mtl_file.hpp>
#include <tapestry/io/names_file.hpp>
#include <tapestry/io/network_file.hpp>
#include <tapestry/io/npy.hpp>
#include <tapestry/io/npy_header.hpp>
#include <tapestry/io/npz_file.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/obj_writer.hpp>
#include <tapestry/io/png_scan.hpp>
#include <tapestry/io/run_lock.hpp>
#include <tapestry/io/safetensors_file.hpp>
#include <tapestry/io/safetensors_header.hpp>
#include <tapestry/io/sha256.hpp>
#include <tapestry/io/text_lines.hpp>
#include <tapestry/io/utf8.hpp>
#include <tapestry/io/zip_archive.hpp>
#include <tapestry/io/zip_writer.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/anchor_match.hpp>
#include <tapestry/loss/classification.hpp>
#include <tapestry/loss/logistic.hpp>
#include <tapestry/loss/max_score.hpp>
#include <tapestry/loss/objectness.hpp>
#include <tapestry/loss/overlap.hpp>
#include <tapestry/loss/prediction.hpp>
#include <tapestry/loss/responsible.hpp>
#include <tapestry/loss/smoothness.hpp>
#include <tapestry/loss/yolo_training.hpp>
#include <tapestry/nn/activation.hpp>
#include <tapestry/nn/batch_norm.hpp>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/convolution.hpp>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/convolution_region.hpp>
#include <tapestry/nn/convolution_weight_adjoint.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/few_channel_convolution.hpp>
#include <tapestry/nn/layout.hpp>
#include <tapestry/nn/packed_convolution.hpp>
#include <tapestry/nn/pointwise.hpp>
#include <tapestry/nn/pooling.hpp>
#include <tapestry/nn/reduction.hpp>
#include <tapestry/nn/upsample.hpp>
#include <tapestry/nn/vector_kernels.hpp>
#include <tapestry/nn/winograd.hpp>
#include <tapestry/nn/winograd_plan.hpp>
#include <tapestry/optim/adam.hpp>
#include <tapestry/raster/barycentric.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/light.hpp>
#include <tapestry/raster/render_faces.hpp>
#include <tapestry/raster/render_textured.hpp>
#include <tapestry/raster/texture_atlas.hpp>
#include <tapestry/raster/texture_cube.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/raster/triangle_setup.hpp>
#include <tapestry/raster/view_clip.hpp>
#include <tapestry/raster/visibility.hpp>
#include <tapestry/version.hpp>

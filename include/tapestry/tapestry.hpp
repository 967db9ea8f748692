#pragma once
/// \file
/// A reverse-mode tape, and on it everything that differentiates: one gradient runs from a detector's output
/// back to the paint on a car. This header includes all of it but implementation.hpp: one source file of a
/// program includes that, or the program links tapestry::compiled. Including only what a file needs compiles
/// faster. Experiments with camouflages are in laboratory.hpp.
///
/// The layers, a header of one using only its own folder and those before it:
///   core                          arrays, checks, errors, random numbers, threads
///   autodiff                      the tape, variables, and how an operation joins it
///   geometry, image, nn, optim    meshes and cameras; pictures; network layers; Adam
///   raster, detect                mesh to picture; picture to boxes
///   loss, io                      terms of the objective; files in and out
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/array_derivatives.hpp>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/boost.hpp>
#include <tapestry/autodiff/checkpoint.hpp>
#include <tapestry/autodiff/checkpointed_scan.hpp>
#include <tapestry/autodiff/compressed_jacobian.hpp>
#include <tapestry/autodiff/derivatives.hpp>
#include <tapestry/autodiff/dual.hpp>
#include <tapestry/autodiff/eigen.hpp>
#include <tapestry/autodiff/eigen_derivatives.hpp>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/gradient_check.hpp>
#include <tapestry/autodiff/implicit_function.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/matrix.hpp>
#include <tapestry/autodiff/matrix/determinant.hpp>
#include <tapestry/autodiff/matrix/solve.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/autodiff/sparse_hessian.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/autodiff/tape_statistics.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/block_loop.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/finite.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/core/instruction_set.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/platform.hpp>
#include <tapestry/core/platform/memory.hpp>
#include <tapestry/core/pool.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/core/scoped_timer.hpp>
#include <tapestry/core/vector_exp.hpp>
#include <tapestry/detect.hpp>
#include <tapestry/geometry.hpp>
#include <tapestry/image.hpp>
#include <tapestry/io.hpp>
#include <tapestry/loss.hpp>
#include <tapestry/nn.hpp>
#include <tapestry/optim.hpp>
#include <tapestry/raster.hpp>
#include <tapestry/version.hpp>

#pragma once
/// \file
/// The compiled part of evaluate/, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/evaluate/implementation/average_precision.hpp>
#include <tapestry/evaluate/implementation/controls.hpp>
#include <tapestry/evaluate/implementation/dataset/coco.hpp>
#include <tapestry/evaluate/implementation/dataset/folders.hpp>
#include <tapestry/evaluate/implementation/detection_rate.hpp>
#include <tapestry/evaluate/implementation/matched_noise.hpp>
#include <tapestry/evaluate/implementation/measurement.hpp>
#include <tapestry/evaluate/implementation/paired_bootstrap.hpp>
#include <tapestry/evaluate/implementation/protocol_cells.hpp>
#include <tapestry/evaluate/implementation/two_level_difference.hpp>
#include <tapestry/evaluate/implementation/views.hpp>

#pragma once
/// \file
/// All of evaluate/ that programs name: what judges a camouflage: detection rates, controls and their
/// intervals.
#include <tapestry/evaluate/average_precision.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/dataset/dataset.hpp>
#include <tapestry/evaluate/dataset/readers.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>
#include <tapestry/evaluate/protocol_cells.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>
#include <tapestry/evaluate/views.hpp>

#pragma once
/// \file
/// All of image/ that programs name: pictures: sizes, colours, and what a camera does to them.
#include <tapestry/image/batch.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/image/colour_space_variable.hpp>
#include <tapestry/image/crop.hpp>
#include <tapestry/image/fourier_transform.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <tapestry/image/resize.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/image/transform/colour_change.hpp>

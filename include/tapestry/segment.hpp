#pragma once
/// \file
/// All of segment/ that programs name: picture to mask of the car.
#include <tapestry/segment/car_component.hpp>
#include <tapestry/segment/u2_net.hpp>
#include <tapestry/segment/u2_net_description.hpp>

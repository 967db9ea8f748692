#pragma once
/// \file
/// All of optim/ that programs name: Adam.
#include <tapestry/optim/adam.hpp>

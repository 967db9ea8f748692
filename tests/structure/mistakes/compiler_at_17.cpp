#include <tapestry/autodiff.hpp>

// The compiled parts of the readers alone; those of networks are in another file.
#include <tapestry/io/implementation.hpp>

#include <tapestry/detect/implementation.hpp>

// The compiled parts of the readers alone; those of networks are beside this.
#include <tapestry/io/implementation.hpp>

#include <tapestry/detect/implementation.hpp>

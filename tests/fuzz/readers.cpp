// The compiled parts of the readers alone; those of networks are beside this.
#undef TAPESTRY_EXTERN_KERNELS
#include <tapestry/implementation.hpp>

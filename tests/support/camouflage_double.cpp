// Parts of camouflage/ in double for tests of gradients: the library compiles it for float alone.
#include <tapestry/camouflage/implementation/method/method.hpp>
#include <tapestry/camouflage/implementation/objective.hpp>
#include <tapestry/camouflage/implementation/paint.hpp>
#include <tapestry/camouflage/implementation/photo_session.hpp>
#include <tapestry/camouflage/implementation/run_state.hpp>
#include <tapestry/camouflage/implementation/shape_parameter.hpp>
#include <tapestry/camouflage/implementation/training.hpp>
#include <tapestry/camouflage/implementation/view.hpp>

#define TAPESTRY_SCALAR double
#include <tapestry/camouflage/implementation/instances.inl>

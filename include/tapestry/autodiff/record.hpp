#pragma once
/// Operations of one's own on the tape: record_scalar(), record_array() and record_arrays() with a
/// hand-written pullback, record_tangent() and its like for second order.
#include <tapestry/autodiff/detail/arrays/record_tangent.hpp>

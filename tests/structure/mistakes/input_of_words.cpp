#include <string>
#include <tapestry/autodiff.hpp>

auto f(tapestry::Tape<double>& tape) { return tape.input(std::string("2")); }

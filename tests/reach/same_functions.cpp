// Functions that C libraries for two processors round otherwise, from those that they round alike: preloaded
// into both programs, all else can be compared to the bit.
#include <cmath>

extern "C" {
float tanhf(float x) { return static_cast<float>(std::tanh(static_cast<double>(x))); }
float atanhf(float x) { return static_cast<float>(std::atanh(static_cast<double>(x))); }
float log1pf(float x) { return static_cast<float>(std::log1p(static_cast<double>(x))); }
float expm1f(float x) { return static_cast<float>(std::expm1(static_cast<double>(x))); }
double hypot(double x, double y) { return std::sqrt(x * x + y * y); }
}

#include <dlfcn.h>

#include <exception>
#include <iostream>
#include <string>
#include <vector>

// Loads two libraries of picture.cpp, whose symbols are "global" or "local", and lets each record in the
// middle of the other's recording.
namespace {
using Slope = double (*)(double x, double (*meanwhile)(double));
using Threads = int (*)(int limit);
std::vector<Slope> slopes;
double first(double x) { return slopes[0](x, nullptr); }
double second(double x) { return slopes[1](x, nullptr); }

void require(bool holds, const std::string& what) {
  if (!holds) throw std::string(what);
}
}  // namespace

int main(int count, char** arguments) {
  try {
    require(count == 4, "usage: load_libraries global|local <library> <library>");
    const bool is_global = std::string(arguments[1]) == "global";
    std::vector<Threads> threads;
    for (int i = 2; i < 4; ++i) {
      void* const library = dlopen(arguments[i], RTLD_NOW | (is_global ? RTLD_GLOBAL : RTLD_LOCAL));
      require(library != nullptr, library == nullptr ? dlerror() : "");
      slopes.push_back(reinterpret_cast<Slope>(dlsym(library, "picture_slope")));
      threads.push_back(reinterpret_cast<Threads>(dlsym(library, "picture_threads")));
    }
    // d (2 Σ x² / 2) / dx = 2 x
    require(slopes[0](3, nullptr) == 6 && slopes[1](4, nullptr) == 8, "a slope is wrong");
    require(slopes[0](5, second) == 10 && slopes[1](6, first) == 12,
            "a slope with the other's meanwhile is wrong");
    for (const Threads limit : threads)
      require(limit(3) == 3 && limit(1) == 1, "a limit of threads is not kept");
    return 0;
  } catch (const std::string& what) {
    std::cerr << what << '\n';
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
  }
  return 1;
}

// Entry points that libFuzzer calls. The target is named by TAPESTRY_FUZZ_TARGET; with TAPESTRY_FUZZ_SEEDS
// its seeds are written to that folder, and the program ends. Without a target, all names are printed.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "target.hpp"

namespace {
using namespace tapestry::fuzz;

const Target* chosen = nullptr;

void write_seeds(const std::string& folder) {
  std::size_t number = 0;
  for (const std::string& seed : chosen->seeds())
    std::ofstream(folder + "/" + std::to_string(number++), std::ios::binary) << seed;
}
}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("TAPESTRY_FUZZ_TARGET");
  for (const Target& target : targets()) {
    if (name == nullptr) std::printf("%s\n", target.name.c_str());
    if (name != nullptr && target.name == name) chosen = &target;
  }
  if (chosen == nullptr) std::exit(name == nullptr ? 0 : 2);
  if (const char* folder_of_seeds = std::getenv("TAPESTRY_FUZZ_SEEDS")) {
    write_seeds(folder_of_seeds);
    std::exit(0);
  }
  (void)folder();  // before libFuzzer's own handlers of the end, so that it vanishes after them
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  try {
    read_both(*chosen, std::string(reinterpret_cast<const char*>(bytes), size));
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "neither taken nor refused: %s\n", fault.what());
    std::abort();
  }
  return 0;
}

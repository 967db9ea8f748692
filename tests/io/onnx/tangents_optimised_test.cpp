// Second order through networks as today's exporters write them.
#include <set>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../../support/paths.hpp"
#include "../../support/raw_numbers.hpp"
#include "../../support/tangent_check.hpp"

namespace files = std::filesystem;
using namespace tapestry;

namespace {
/// The network of a file; nothing if it runs in stages only.
std::optional<nn::Network<double>> network_of(const files::path& path) {
  try {
    return nn::Network<double>(io::read_onnx(path));
  } catch (const FileError&) {
    return std::nullopt;
  }
}
}  // namespace

TEST_CASE("The second order of exported networks is that of central differences", "[io][onnx][gradient]") {
  const files::path folder = test::in_shared("data/exports");
  if (!files::exists(folder)) WARN("skipped: no exports in TAPESTRY_SHARED");
  if (!files::exists(folder)) return;
  std::set<std::string> known, refused;
  for (const auto& entry : files::recursive_directory_iterator(folder)) {
    const files::path &path = entry.path(), parent = path.parent_path();
    if (path.extension() != ".onnx") continue;
    const std::string name = parent.filename().string() + "/" + path.stem().string();
    CAPTURE(name);
    const auto plain = network_of(path);
    if (!plain) continue;
    const auto x = test::raw_numbers<float>(parent / "in.bin");
    std::size_t smooth = 0;
    while (files::exists(parent / ("w." + std::to_string(smooth) + ".bin"))) ++smooth;
    try {
      const auto errors = test::TangentCheck(*plain, {x.begin(), x.end()}).errors(smooth, 1e-7);
      CAPTURE(errors.value, errors.tangent, errors.gradient, errors.second);
      // Results of a quantised network are steps, which its derivatives pass straight through.
      const bool has_steps = name.ends_with("/qdq");
      CHECK((has_steps ? std::max(errors.value, errors.gradient) : errors.largest()) <= 1e-7);
      known.insert(name);
    } catch (const DomainError&) {
      refused.insert(name);
    }
  }
  CHECK(known.size() == 16);
  CHECK(refused == std::set<std::string>{"roi_align_adaptive/dyn18", "roi_align_adaptive/leg17"});
}

// Makes the bundled default: car meshes, and frames of the sedan in street scenes to paint it in.
#include <tapestry/io/mesh_writers.hpp>

#include "../scenes/car.hpp"
#include "../scenes/drawn_frames.hpp"
#include "shell/program.hpp"
#include "shell/run_folder.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;
using namespace tapestry::scenes;

struct Options {
  std::string output = TAPESTRY_ASSETS;
  std::uint64_t seed = 1;
  std::size_t size = 256;
  std::size_t train = 0;
  std::size_t test = 80;
};

void describe(CLI::App& app, Options& options) {
  app.add_option("--output", options.output,
                 "folder to write to; files of the same names are replaced, and other frames there refused; "
                 "left out, the bundled assets'")
      ->default_str("");
  app.add_option("--seed", options.seed, "of the scenes");
  app.add_option("--size", options.size, "side of a frame, pixels")->check(CLI::Range(32, 2048));
  app.add_option("--train", options.train, "frames to optimise on; camouflage draws the same ones itself")
      ->check(CLI::Range(0, 9999));
  app.add_option("--test", options.test, "frames held out")->check(CLI::Range(1, 9999));
}

void write_cars(const std::string& folder) {
  const std::pair<const char*, BodyStyle> cars[]{{"car_sedan", BodyStyle::sedan},
                                                 {"car_hatchback", BodyStyle::hatchback},
                                                 {"car_suv", BodyStyle::suv},
                                                 {"van", BodyStyle::van}};
  for (const auto& [name, style] : cars) {
    CarOptions options;
    options.style = style;
    io::write_obj(folder + "/" + name + ".obj", make_car(options));
  }
}

std::string name_of_frame(std::size_t index) { return formatted("%03zu.npz", index); }

/// \throws Error (in_use) for a folder with frames that would remain: readers use all frames of a folder
void require_all_replaced(const std::string& folder, std::size_t count) {
  if (!is_folder(folder, ErrorKind::write)) return;
  std::set<std::string> names;
  for (std::size_t index = 0; index < count; ++index) names.insert(name_of_frame(index));
  const auto stays = [&](const std::filesystem::path& file) {
    return file.extension() == ".npz" && !names.contains(file.filename().string());
  };
  const auto others = io::listed_paths(folder, stays);
  if (!others.empty())
    throw Error(ErrorKind::in_use, folder + " holds frames that are not replaced, such as " + others.front() +
                                       "; remove them, or give another --output");
}

void write_frames(const std::string& folder, const DrawnFrames& frames) {
  make_writable_folder(folder);
  parallel_for(frames.count, [&](std::size_t index) {
    io::write_frame(folder + "/" + name_of_frame(index), frames(index));
  });
}

int make_assets(const Options& options) {
  const RunFolder claim(options.output, !is_there(options.output, ErrorKind::write));
  const std::string train = options.output + "/frames/train", test = options.output + "/frames/test";
  require_all_replaced(train, options.train);
  require_all_replaced(test, options.test);
  write_cars(options.output);
  using Stream = DrawnFrames::Stream;
  if (options.train > 0) write_frames(train, {options.train, Stream::train, options.seed, options.size});
  write_frames(test, {options.test, Stream::test, options.seed, options.size});
  remark("wrote 4 meshes and " + std::to_string(options.train + options.test) + " frames to " +
         options.output);
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  auto app = command_line("Makes the bundled default: car meshes and frames of the sedan in street scenes.");
  Options options;
  describe(app, options);
  app.footer("  make_assets --output assets --train 20 --test 10");
  return run_program(app, argc, argv, [&] { return make_assets(options); });
}

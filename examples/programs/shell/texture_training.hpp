#pragma once
#include <tapestry/camouflage/run_state.hpp>
#include <tapestry/io/text_lists.hpp>
#include <tapestry/loss/printability.hpp>
#include <tapestry/raster/used_texels.hpp>
#include "settings.hpp"
#include "texture_description.hpp"

namespace tapestry::shell {
// Beginning, length and resumption of a run that optimises a texture, shared by several programs.

/// Default of --epochs. Drawn scenes are many and quick; frames may be few, or too many for more than the
/// paper's five passes.
inline std::size_t default_epochs(std::size_t views, bool drawn) {
  return drawn ? 20 : std::max<std::size_t>(5, block_count(2400, views));
}

/// \param description  of the car's texture
inline Array<float, 2> start_texture(const OptimisationSettings& settings, const raster::PaintedMesh& car,
                                     const Json& description) {
  const io::InputLedger::Role role("start");
  const std::size_t count = car.layout.texel_count(car.mesh);
  if (settings.start == "zero") return zeros<float, 2>({count, 3});
  if (is_texture_file(settings.start))
    return camouflage::parameter_of_colours(read_fitting_paint(settings.start, car, description).colours);
  if (settings.start == "own") return camouflage::parameter_of_colours(camouflage::own_colours<float>(car));
  Random random = Random(settings.seed).fork(0x7374617274ULL);
  return camouflage::parameter_of_colours(camouflage::random_colours<float>(count, random));
}

/// The method that --method names.
/// \throws FileError (mismatch) if the mesh lacks the parts that the method paints
inline camouflage::Method<float> chosen_method(const OptimisationSettings& settings,
                                               const raster::PaintedMesh& car, const std::string& mesh_path) {
  try {
    return camouflage::method_by_name<float>(settings.method, car, settings.seed);
  } catch (const Error& error) {
    throw FileError(error.kind(), {mesh_path, "", error.what()});
  }
}

/// The texels to print among those that a method paints, [height, width]: in an atlas those that faces refer
/// to, in cubes all of them.
inline std::shared_ptr<const Array<float, 2>> texels_to_print(const raster::PaintedMesh& car,
                                                              const camouflage::Method<float>& method) {
  auto printed = car.layout.traits().is_picture ? raster::used_texels<float>(car)
                                                : filled<float, 2>({1, car.layout.texel_count(car.mesh)}, 1);
  const auto painted = camouflage::painted_texels(method);
  for (std::size_t texel = 0; texel < painted.size(); ++texel)
    if (painted[texel] == 0) printed.data()[texel] = 0;
  return std::make_shared<const Array<float, 2>>(std::move(printed));
}

/// Colours that a printer can make: from --palette, or printable_colours(); null without printability.
inline std::shared_ptr<const Array<double, 2>> palette_of(const OptimisationSettings& settings) {
  if (settings.objective.printability == 0) return nullptr;
  const io::InputLedger::Role role("palette");
  return std::make_shared<const Array<double, 2>>(
      settings.palette.empty() ? loss::printable_colours() : io::read_palette(settings.palette));
}

/// Resumes from a checkpoint if there is one.
/// \param identity  of the run, see identity_text()
/// \throws Error (in_use) for the checkpoint of another run; FileError (mismatch) for one that does not fit
///         this training
inline void restore_training(const std::string& path, const std::string& identity,
                             camouflage::Training<float>& training) {
  if (!is_there(path, ErrorKind::malformed)) return;
  auto checkpoint = camouflage::read_checkpoint<float>(path);
  if (checkpoint.settings != identity)
    throw Error(ErrorKind::in_use, path + ": belongs to a run with other settings");
  if (checkpoint.state.parameter.shape() != training.parameter().shape())
    throw file_mismatch({path, "", "its texture has another size than the run's",
                         std::to_string(training.parameter().shape(0)) + " texels",
                         std::to_string(checkpoint.state.parameter.shape(0))});
  if (checkpoint.state.step > training.step_count())
    throw file_mismatch({path, "", "more steps taken than the run has",
                         "at most " + std::to_string(training.step_count()),
                         std::to_string(checkpoint.state.step)});
  training.restore(std::move(checkpoint.state));
}
}  // namespace tapestry::shell

#pragma once
#include <tapestry/camouflage/view_store.hpp>
#include "detector_inputs.hpp"
#include "mask_rule.hpp"
#include "mesh_inputs.hpp"
#include "texture_description.hpp"

namespace tapestry::shell {
namespace fs = std::filesystem;

// Readers of files are compiled once for all programs, because the formats and the drawn scenes compile
// slowly.

/// Fills in the bundled files for those that the user left out.
void fill_in_bundled(SceneSettings& scene);

void fill_in_bundled(DetectorSettings& detector);

/// The car as painted, before any frame is read.
struct Car {
  raster::PaintedMesh painted;
  std::vector<std::string> warnings;
  Json description{};                         ///< of its texture, see description_of()
  std::vector<std::string> material_files{};  ///< read beside the mesh
  double starved_share = 0;                   ///< see raster::starved_share()
  double scale = 1;                           ///< scale of the mesh besides its file's
};

Car load_car(const SceneSettings& settings);

/// \throws FileError (mismatch) if most of the paint would have no texels of its own
void require_texels(const SceneSettings& settings, const Car& car);

/// The frames to optimise on and those to measure on; the same when the folder is not divided.
struct FrameLists {
  std::vector<std::string> train;
  std::vector<std::string> test;
  std::size_t drawn = 0;  ///< scenes drawn to optimise on, instead of `train`
  bool held_out = false;
  bool posed = false;  ///< frames carry poses instead of cameras, for a car normalised to length 2
};

FrameLists find_frames(const SceneSettings& scene);

/// At most so many of some frames, evenly spread.
inline std::vector<std::string> thinned(const std::vector<std::string>& paths, std::size_t most) {
  if (paths.size() <= most) return paths;
  std::vector<std::string> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(paths[i * paths.size() / most]);
  return some;
}

void require_one_scale(const FrameLists& lists);

/// \param posed  see FrameLists; equal for all frames of a run. None: not known yet
io::Frame load_frame(const std::string& path, const MaskRule& mask, std::optional<bool> posed);

using FrameLoaders = std::vector<camouflage::ViewStore<float>::Loader>;

FrameLoaders frame_loaders(const std::vector<std::string>& paths, const MaskRule& mask, bool posed);

/// Loaders of the frames to optimise on. Drawn frames use their own masks, or silhouettes if the rule
/// requires these.
FrameLoaders train_loaders(const FrameLists& lists, const MaskRule& mask);

/// A detector beside the first one.
struct FurtherDetector {
  detect::Detector<float> detector;
  std::size_t class_index = 0;
};

/// Everything a run reads, checked.
struct Inputs {
  detect::Detector<float> detector;
  std::size_t class_index = 0;
  std::vector<FurtherDetector> ensemble{};  ///< further detectors to optimise against
  Car car;
  FrameLists frames;
  std::vector<std::string> warnings;
  std::optional<camouflage::PhotoLight> photo_light{};  ///< rule that estimates the light, if any
  bool keeps_photograph = true;                         ///< see --unpainted
  std::shared_ptr<const Array<double, 2>> palette{};    ///< printable colours, if required
  MaskRule mask{};                                      ///< source of the frames' masks
};

/// The rule that estimates light, with a detector that decides whether frames without a mask show the car,
/// see camouflage::PhotoLight::shows_car.
/// \param detector  must outlive the result
std::optional<camouflage::PhotoLight> witnessed(std::optional<camouflage::PhotoLight> rule,
                                                const detect::Detector<float>& detector,
                                                std::size_t class_index, const DetectorSettings& settings);

/// Settings of a store of views in the input of the inputs' detector; both must outlive the store.
camouflage::ViewStore<float>::Settings store_settings(const Inputs& inputs, const SceneSettings& scene,
                                                      const DetectorSettings& detector, std::size_t keep_mib);

/// Roles of inputs in ledgers, see io::InputLedger::Role.
inline constexpr const char *frame_role = "frame", *mesh_role = "mesh", *camouflage_role = "camouflage";

/// Role of a detector's files: of the first, or of a further one, by the path that an option gives.
inline std::string role_of_detector(const std::string& further = "") {
  return further.empty() ? "detector" : "detector " + further;
}

/// Records frames, and the masks beside them, in the program's ledger before they are read.
void note_frames(const std::vector<std::string>& frames, const MaskRule& mask);

/// Warns if bundled frames, which show the bundled sedan, are used with another mesh.
std::vector<std::string> warnings_about(const SceneSettings& scene);

/// load_detector(), read in the role of the first.
detect::Detector<float> load_first_detector(const DetectorSettings& settings,
                                            std::vector<std::string>& warnings,
                                            const std::vector<std::string>& layers = {});

/// \param layers  as for load_detector()
Inputs load_inputs(SceneSettings& scene, DetectorSettings& detector,
                   const std::vector<std::string>& layers = {});

/// A further detector, from one file.
/// \param option    that named it, for errors
/// \param settings  of the first detector: names, class and size apply to all
/// \param layers    as for load_detector()
FurtherDetector load_further_detector(const std::string& option, const std::string& path,
                                      DetectorSettings settings, std::vector<std::string>& warnings,
                                      const std::vector<std::string>& layers = {});

/// Detectors of an ensemble beside `first`, each from one file, and warnings about those that take pictures
/// in another way.
/// \param settings  of the first detector: names, class and size apply to all
std::vector<FurtherDetector> load_ensemble(const std::vector<std::string>& paths,
                                           const DetectorSettings& settings,
                                           const detect::Detector<float>& first,
                                           std::vector<std::string>& warnings);

/// Checks every input; adds all problems and warnings. The settings themselves must have been checked before.
void check_inputs(SceneSettings scene, const DetectorSettings& detector, ProblemList& list,
                  std::vector<std::string>& warnings);
}  // namespace tapestry::shell

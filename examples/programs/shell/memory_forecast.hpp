#pragma once
#include <tapestry/camouflage/run_state.hpp>
#include <tapestry/evaluate/controls.hpp>
#include "camouflage_options.hpp"
#include "inputs.hpp"

namespace tapestry::shell {
/// Memory of a part of a run while it optimises and while it measures, bytes, and the option that lowers it.
struct MemoryPart {
  std::string name, option;
  std::array<std::uint64_t, 2> bytes;
};

/// Memory that a run will take, found before it begins: of the files, which are read; of a few views,
/// prepared and passed through the detectors, times all; of the texture, by figures beside what allocates it.
class MemoryForecast {
 public:
  MemoryForecast(const CamouflageOptions& options, const raster::PaintedMesh& car)
      : options_(options), layout_(car.layout) {
    using Training = camouflage::Training<float>;
    const std::uint64_t texels = layout_.texel_count(car.mesh), copy = 3 * sizeof(float) * texels;
    const std::uint64_t stored = raster::stored_texel_count(layout_, car.mesh),
                        edge = layout_.texels_per_edge;
    const std::uint64_t places = layout_.traits().is_by_face ? car.mesh.faces.size() * edge * edge : texels;
    const std::uint64_t held = options.survey.controls == "all" ? 13 : 6;  // parameter, paints and controls
    const auto files = static_cast<std::uint64_t>(peak_mib() * (1 << 20U));
    noise_ = evaluate::matched_controls_bytes * places + 4 * copy;  // drawn before the other controls
    textures_ = held * copy + 12 * sizeof(float) * stored;          // with four pyramids, or files
    parts_ = {{"files", "--weights", {files, files}},
              {"texture and optimiser", "--texels", {Training::kept_bytes(texels), 0}},
              {"pyramid and adjoints", "--texels", {Training::step_bytes(texels, stored), 0}},
              {"checkpoint", "--texels", {camouflage::checkpoint_copies * Training::kept_bytes(texels), 0}}};
  }

  /// Prepares some views of a store, passes them through the objective's detectors on the tape, and prints.
  /// \param further  views that are measured, in another store; 0: those of this one
  /// \throws Error (limit), naming the largest part, if the process may not take as much
  void complete(camouflage::ViewStore<float>& store, camouflage::Objective<float>& objective,
                std::size_t further) {
    std::vector<std::shared_ptr<const camouflage::View<float>>> views(
        std::min<std::size_t>(16, store.size()));
    parallel_for(views.size(),
                 [&](std::size_t i) { views[i] = store.view(i * store.size() / views.size()); });
    const auto of = [&](std::size_t count) {
      return std::min<std::uint64_t>(store.kept_bytes() * count / views.size(), store.settings().keep_bytes);
    };
    const std::size_t measured = further > 0 ? further : store.size();
    parts_.push_back({"prepared views", "--keep-mib", {of(store.size()) + of(further), of(measured)}});
    constexpr std::size_t most = 160, bytes = 30;  // on a sheet; of a pixel, collected, laid out and filed
    const std::size_t pixels = store.settings().height * store.settings().width;
    const std::uint64_t pictures = std::min(measured, most) * pixels * bytes;
    parts_.push_back({"textures measured", "--texels", {0, std::max(noise_, textures_ + pictures)}});
    std::erase_if(views, [](const auto& view) { return view->visible_pixels == 0; });
    const bool is_side_by_side = objective.prefers_views_side_by_side();
    if (!is_side_by_side) views.resize(std::min<std::size_t>(views.size(), 2));
    if (objective.method().shape) views.clear();  // they take the whole texture
    std::uint64_t pass = 0, layers = 0;
    for (const auto& view : views) pass = std::max(pass, bytes_of_pass(objective, view));
    for (std::size_t member = 0; member <= options_.optimisation.ensemble.size(); ++member)
      layers += objective.kept_layers(member).bytes() * store.size() / std::max<std::size_t>(1, views.size());
    const bool keeps = options_.optimisation.conditions.empty();  // photographs change all over
    layers = std::min<std::uint64_t>(layers, keeps ? options_.keep_layers_mib << 20U : 0);
    const auto threads = static_cast<std::size_t>(thread_count());
    const std::size_t lanes = is_side_by_side ? std::min(threads, options_.optimisation.batch) : 1;
    parts_.push_back({"kept layers", "--keep-layers-mib", {layers, layers}});
    parts_.push_back({"detector in a step", "--threads", {lanes * pass, (threads + 2) * pass / 2}});
    objective.times() = {};
    std::string line = "memory, MiB:";
    for (const MemoryPart& part : parts_)
      if (part.bytes[0] > 0) line += " " + part.name + " " + mib(part.bytes[0]) + ",";
    remark(line + " together " + mib(sum(0)) + "; while measuring " + mib(sum(1)) +
           (memory_limit > 0 ? "; allowed " + mib(memory_limit) : ""));
    require_fitting();
  }

 private:
  static std::string mib(std::uint64_t bytes) { return std::to_string((bytes + (1U << 19U)) >> 20U); }

  [[nodiscard]] std::uint64_t sum(std::size_t phase, const std::string& option = "") const {
    std::uint64_t bytes = 0;
    for (const MemoryPart& part : parts_)
      if (option.empty() || part.option == option) bytes += part.bytes[phase];
    return bytes;
  }

  void require_fitting() const {
    const std::size_t phase = sum(1) > sum(0) ? 1 : 0;
    if (memory_limit == 0 || sum(phase) <= memory_limit) return;
    const auto& most =
        *std::ranges::max_element(parts_, {}, [&](const auto& part) { return part.bytes[phase]; });
    std::string word = mib(most.bytes[phase]) + " of them for " + most.name + ", see " + most.option;
    if (most.option == "--texels") word += ", of which " + std::to_string(finest()) + " would fit";
    throw Error(ErrorKind::limit, "too little memory: the run needs " + mib(sum(phase)) +
                                      " MiB and may take " + mib(memory_limit) +
                                      " (--memory-mib, else seven eighths of the machine's); " + word);
  }

  /// The largest --texels that fits; 0 if none does.
  [[nodiscard]] std::size_t finest() const {
    double share = 1;
    for (const std::size_t phase : {0U, 1U}) {
      const auto texture = static_cast<double>(sum(phase, "--texels"));
      const auto others = static_cast<double>(sum(phase)) - texture;
      share = std::min(share, (static_cast<double>(memory_limit) - others) / texture);
    }
    return static_cast<std::size_t>(
        static_cast<double>(options_.scene.texels) *
        std::pow(std::max(0.0, share), layout_.traits().is_by_face ? 1.0 / 3 : 0.5));
  }

  /// Memory of a gradient by one view.
  static std::uint64_t bytes_of_pass(camouflage::Objective<float>& objective,
                                     const std::shared_ptr<const camouflage::View<float>>& view) {
    auto& pool = platform::PagePool::shared();
    pool.release();
    const std::size_t before = pool.use().in_use;
    Tape<float> tape;
    const auto scope = tape.activate();
    camouflage::DrawnPaint<float> paint;
    paint.is_of_view = true;
    paint.texels = tape.input(filled<float, 2>({view->paint_to_picture->texel_count, 3}, 0.5F));
    tape.reverse(objective.evaluate(paint, std::span(&view, 1)).loss);
    return pool.use().peak - before;
  }

  const CamouflageOptions& options_;
  raster::TextureLayout layout_;
  std::uint64_t noise_, textures_;
  std::vector<MemoryPart> parts_;
};
}  // namespace tapestry::shell

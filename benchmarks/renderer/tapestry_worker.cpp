// The car as this library renders it.
#include <cstddef>
#include <functional>
#include <string>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/render_textured.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/version.hpp>
#include <vector>

#include "worker_program.hpp"

namespace tapestry::benchmarks {
namespace {

using Operator = raster::TextureOperator<float>;

const raster::Light white{1, 0, {0, 0, 1}, {1, 1, 1}};

class TapestryRenderer {
 public:
  TapestryRenderer(const Scene& scene, const WorkerOptions& options)
      : scene_(scene),
        options_(options),
        painted_(scene.mesh.faces.size(), 1),
        texels_adjoint_(zeros<float, 2>(scene.texels.shape())),
        picture_adjoint_(filled<float, 3>({options.size, options.size, 3}, 1.0F)) {
    limit_threads(options.threads);
    samples_ = static_cast<std::size_t>(options.variant.at(0) - '0');
    if (options.stage == "visibility") run_ = [this](const auto& camera) { fragments_ = list(camera); };
    if (options.stage == "frame") run_ = [this](const auto& camera) { picture_ = frame(camera); };
    if (options.stage == "step") run_ = [this](const auto& camera) { step(operator_of(camera)); };
    if (options.stage == "texture-backward" || options.variant.find("cached") != std::string::npos)
      prepare_operators();
    if (!run_ && operators_.empty())
      throw Error(ErrorKind::usage, "no stage '" + options.stage + "' of variant '" + options.variant + "'");
  }

  [[nodiscard]] std::string name() const { return "Tapestry " TAPESTRY_VERSION_TEXT; }

  void run() {
    if (operators_.empty()) {
      for (const geometry::Camera& camera : scene_.cameras) run_(camera);
      return;
    }
    for (const Operator& picture : operators_) {
      if (options_.variant.find("forward") != std::string::npos) {
        picture_ = raster::render(picture, scene_.texels);
      } else if (options_.stage == "step") {
        step(picture);
      } else {
        raster::render_adjoint(picture, picture_adjoint_, texels_adjoint_);
      }
    }
  }

  [[nodiscard]] std::vector<float> first_answer() {
    const geometry::Camera& camera = scene_.cameras.front();
    if (options_.stage == "visibility") {
      std::vector<float> faces(options_.size * options_.size, -1.0F);
      for (const auto& band : list(camera).bands)
        for (const raster::PackedFragment& fragment : band)
          faces[fragment.pixel] = static_cast<float>(fragment.face);
      return faces;
    }
    if (options_.stage == "frame") {
      const auto picture = frame(camera);
      return {picture.data(), picture.data() + picture.size()};
    }
    if (options_.stage == "texture-backward") return gradient_of_faces(camera);
    return {};
  }

 private:
  [[nodiscard]] raster::FragmentList list(const geometry::Camera& camera) const {
    return raster::list_fragments(scene_.mesh, camera, options_.size, options_.size, samples_);
  }

  [[nodiscard]] Operator operator_of(const geometry::Camera& camera) const {
    return raster::texture_operator<float>(scene_.mesh, painted_, camera, options_.size, options_.size,
                                           scene_.layout, white, samples_);
  }

  [[nodiscard]] Array<float, 3> frame(const geometry::Camera& camera) const {
    return raster::render_textured(scene_.mesh, painted_, camera, options_.size, options_.size, scene_.layout,
                                   white, scene_.texels, samples_)
        .colour;
  }

  void step(const Operator& picture) {
    picture_ = raster::render(picture, scene_.texels);
    raster::render_adjoint(picture, picture_, texels_adjoint_);
  }

  void prepare_operators() {
    for (const geometry::Camera& camera : scene_.cameras) operators_.push_back(operator_of(camera));
  }

  /// The gradient of the sum of the red pixels to one colour a face: each face's visible area.
  [[nodiscard]] std::vector<float> gradient_of_faces(const geometry::Camera& camera) const {
    const auto picture =
        raster::texture_operator<float>(scene_.mesh, painted_, camera, options_.size, options_.size,
                                        {raster::TextureKind::cube, 0, 0, 1, 1}, white, samples_);
    auto gradient = zeros<float, 2>({scene_.mesh.faces.size(), 3});
    raster::render_adjoint(picture, picture_adjoint_, gradient);
    std::vector<float> red(scene_.mesh.faces.size());
    for (std::size_t face = 0; face < red.size(); ++face) red[face] = gradient(face, 0);
    return red;
  }

  const Scene& scene_;
  const WorkerOptions& options_;
  std::vector<std::uint8_t> painted_;
  std::size_t samples_ = 1;
  std::function<void(const geometry::Camera&)> run_;
  std::vector<Operator> operators_;
  raster::FragmentList fragments_;
  Array<float, 3> picture_;
  Array<float, 2> texels_adjoint_;
  Array<float, 3> picture_adjoint_;
};

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::TapestryRenderer>(
      argc, argv, "1x1, 2x2, 4x4 or 8x8; -cached (step) or -forward (texture-backward) may follow");
}

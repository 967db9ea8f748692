// The car as this library renders it.
#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/detail/vertex_gradient.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "counted_memory.hpp"
#include "worker_program.hpp"

namespace tapestry::benchmarks {
namespace {
using Operator = raster::TextureOperator<float>;
using Motion = std::vector<geometry::Vector3>;

const raster::Light white{1, 0, {0, 0, 1}, {1, 1, 1}};
const raster::TextureLayout colour_a_face{raster::TextureKind::cube, 0, 0, 1, 1};
const raster::TextureLayout colour_a_position{raster::TextureKind::vertex, 0, 0, 1, 0};

class TapestryRenderer {
 public:
  TapestryRenderer(const Scene& scene, const WorkerOptions& options)
      : scene_(scene),
        options_(options),
        body_{scene.mesh, std::vector<std::uint8_t>(scene.mesh.faces.size(), 1), scene.layout},
        weights_(test::scoring_weights(options.size)) {
    limit_threads(options.threads);
    const std::size_t rate = options.variant.find_first_of("1248");
    if (rate == std::string::npos && !has("automatic"))
      throw Error(ErrorKind::usage, "no coverage rate in '" + options.variant + "'");
    samples_ = has("automatic") ? 0 : static_cast<std::size_t>(options.variant[rate] - '0');
    const bool is_cached = has("-cached");
    if (options.stage == "visibility") run_ = [this](const auto& camera) { fragments_ = list(camera); };
    if (options.stage == "frame") run_ = [this](const auto& camera) { picture_ = frame(camera); };
    if (options.stage == "step" && !is_cached)
      run_ = [this](const auto& camera) { step(operator_of(body_, camera)); };
    if (options.stage == "vertex-gradient") {
      colours_ = test::scoring_colours(scene.mesh);
      body_.layout = colour_a_position;
      run_ = [this](const auto& camera) { motion_ = vertex_gradient(camera); };
    }
    if (options.stage == "texture-backward" || is_cached)
      for (const geometry::Camera& camera : scene.cameras) operators_.push_back(operator_of(body_, camera));
    if (options.stage == "texture-backward" || options.stage == "step")
      texels_adjoint_ = zeros<float, 2>(scene.texels.shape());
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
      if (has("-forward")) {
        picture_ = raster::render(picture, scene_.texels);
      } else if (options_.stage == "step") {
        step(picture);
      } else {
        raster::render_adjoint(picture, weights_, texels_adjoint_);
      }
    }
  }

  /// Most memory that a pass over one view takes from the heap, its answer included, beyond mesh, texture
  /// and, where they are kept, operators.
  [[nodiscard]] double working_mib() {
    fragments_ = {};
    picture_ = {};
    motion_ = {};
    const std::size_t before = bytes_in_use();
    reset_peak_bytes();
    if (run_) run_(scene_.cameras.front());
    return static_cast<double>(peak_bytes() - before) / (1 << 20);
  }

  [[nodiscard]] std::vector<float> answer() {
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
    return options_.stage == "vertex-gradient" ? motion_derivatives() : gradient_of_faces();
  }

 private:
  [[nodiscard]] bool has(const char* part) const { return options_.variant.find(part) != std::string::npos; }

  /// Samples along an axis.
  [[nodiscard]] std::size_t samples_of(const geometry::Camera& camera) const {
    return samples_ > 0
               ? samples_
               : raster::automatic_samples_per_axis(scene_.mesh, camera, options_.size, options_.size);
  }

  [[nodiscard]] raster::FragmentList list(const geometry::Camera& camera) const {
    return raster::list_fragments(scene_.mesh, camera, options_.size, options_.size, samples_of(camera));
  }

  [[nodiscard]] Operator operator_of(const raster::PaintedMesh& body, const geometry::Camera& camera) const {
    return raster::texture_operator<float>(body, camera, options_.size, options_.size, white,
                                           samples_of(camera));
  }

  [[nodiscard]] Array<float, 3> frame(const geometry::Camera& camera) const {
    return raster::render_textured(body_, camera, options_.size, options_.size, white, scene_.texels,
                                   samples_of(camera))
        .colour;
  }

  void step(const Operator& picture) {
    picture_ = raster::render(picture, scene_.texels);
    raster::render_adjoint(picture, picture_, texels_adjoint_);
  }

  /// The derivative of ⟨weights, picture⟩, the positions having colours of their own.
  [[nodiscard]] Motion vertex_gradient(const geometry::Camera& camera) const {
    const raster::Unlit unlit;
    const raster::Surface<float, raster::Unlit> surface{body_, colours_, unlit};
    Motion gradient(scene_.mesh.positions.size(), geometry::Vector3{0, 0, 0});
    if (has("boundary_integral"))
      raster::vertex_adjoint(surface, camera, weights_, gradient,
                             raster::BoundaryIntegral{samples_of(camera), true, edges_});
    else if (has("interior_only"))
      raster::vertex_adjoint(surface, camera, weights_, gradient, raster::InteriorOnly{samples_of(camera)});
    else if (has("neural_mesh_renderer"))
      raster::vertex_adjoint(surface, camera, weights_, gradient,
                             raster::NeuralMeshRenderer{samples_of(camera), true});
    else
      throw Error(ErrorKind::usage, "no gradient model in '" + options_.variant + "'");
    return gradient;
  }

  [[nodiscard]] std::vector<float> motion_derivatives() const {
    const Motion gradient = vertex_gradient(scene_.scored_camera);
    std::vector<float> derivatives;
    for (const Motion& motion : scored_motions(scene_, options_.size)) {
      double sum = 0;
      for (std::size_t i = 0; i < motion.size(); ++i) sum += geometry::dot(gradient[i], motion[i]);
      derivatives.push_back(static_cast<float>(sum));
    }
    return derivatives;
  }

  [[nodiscard]] std::vector<float> gradient_of_faces() const {
    raster::PaintedMesh body = body_;
    body.layout = colour_a_face;
    auto gradient = zeros<float, 2>({scene_.mesh.faces.size(), 3});
    raster::render_adjoint(operator_of(body, scene_.scored_camera), weights_, gradient);
    std::vector<float> red(scene_.mesh.faces.size());
    for (std::size_t face = 0; face < red.size(); ++face) red[face] = gradient(face, 0);
    return red;
  }

  const Scene& scene_;
  const WorkerOptions& options_;
  raster::PaintedMesh body_;
  std::shared_ptr<const raster::MeshEdges> edges_ =
      std::make_shared<const raster::MeshEdges>(raster::mesh_edges(body_.mesh));
  Array<float, 3> weights_;
  Array<float, 2> colours_;  ///< of positions
  std::size_t samples_ = 1;  ///< along an axis; 0: automatic
  std::function<void(const geometry::Camera&)> run_;
  std::vector<Operator> operators_;
  raster::FragmentList fragments_;
  Array<float, 3> picture_;
  Array<float, 2> texels_adjoint_;
  Motion motion_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::TapestryRenderer>(
      argc, argv,
      "1x1, 2x2, 4x4, 8x8 or automatic; -cached (step) or -forward (texture-backward) may follow, "
      "boundary_integral-, "
      "interior_only- or neural_mesh_renderer- stands before (vertex-gradient)");
}

// The car as Embree sees it: primary rays in packets of 16 through a hierarchy built beforehand.
#include <embree3/rtcore.h>

#include "../worker_program.hpp"

namespace tapestry::benchmarks {
namespace {
class EmbreeRenderer {
 public:
  EmbreeRenderer(const Scene& scene, const WorkerOptions& options)
      : scene_(scene), size_(options.size), device_(rtcNewDevice(nullptr)), rays_(rtcNewScene(device_)) {
    if (options.stage != "visibility") throw Error(ErrorKind::usage, "Embree finds visible faces only");
    limit_threads(options.threads);
    rtcSetSceneBuildQuality(rays_, RTC_BUILD_QUALITY_HIGH);
    add_mesh();
    rtcCommitScene(rays_);
    face_.resize(size_ * size_);
    barycentric_.resize(2 * size_ * size_);
  }
  EmbreeRenderer(const EmbreeRenderer&) = delete;
  EmbreeRenderer& operator=(const EmbreeRenderer&) = delete;
  ~EmbreeRenderer() {
    rtcReleaseScene(rays_);
    rtcReleaseDevice(device_);
  }

  [[nodiscard]] std::string name() const { return "Embree " RTC_VERSION_STRING; }

  void run() {
    for (const geometry::Camera& camera : scene_.cameras) trace(camera);
  }

  [[nodiscard]] std::vector<float> answer() {
    trace(scene_.cameras.front());
    return {face_.begin(), face_.end()};
  }

 private:
  void add_mesh() {
    const geometry::Mesh& mesh = scene_.mesh;
    RTCGeometry triangles = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* const positions = static_cast<float*>(rtcSetNewGeometryBuffer(
        triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
    auto* const faces = static_cast<std::int32_t*>(rtcSetNewGeometryBuffer(
        triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(float), mesh.faces.size()));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        positions[3 * i + axis] = static_cast<float>(mesh.positions[i][axis]);
    for (std::size_t i = 0; i < mesh.faces.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) faces[3 * i + k] = mesh.faces[i][k];
    rtcCommitGeometry(triangles);
    rtcAttachGeometry(rays_, triangles);
    rtcReleaseGeometry(triangles);
  }

  /// Constants of all rays of a picture: ray of row i and column j = first + i · down + j · right.
  struct Rays {
    std::array<float, 3> eye, first, down, right;
    float near, far;
  };

  [[nodiscard]] Rays rays_of(const geometry::Camera& camera) const {
    Rays rays{{}, {}, {}, {}, static_cast<float>(camera.near), static_cast<float>(camera.far)};
    const geometry::Vector3 eye = geometry::eye_of(camera);
    const double step = 2 / static_cast<double>(size_);
    const double tan_x = camera.tan_half_fov_x, tan_y = camera.tan_half_fov_y;
    const auto& [x, y, z] = camera.rotation;
    for (std::size_t k = 0; k < 3; ++k) {
      rays.eye[k] = static_cast<float>(eye[k]);
      rays.right[k] = static_cast<float>(step * tan_x * x[k]);
      rays.down[k] = static_cast<float>(step * tan_y * y[k]);
      rays.first[k] = static_cast<float>(z[k] + (step / 2 - 1) * (tan_x * x[k] + tan_y * y[k]));
    }
    return rays;
  }

  /// Packets of 4 × 4 pixels, a row of them at a time.
  void trace(const geometry::Camera& camera) {
    const Rays rays = rays_of(camera);
    parallel_for(block_count(size_, 4), [&](std::size_t row) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      for (std::size_t column = 0; column < size_; column += 4) trace_packet(rays, 4 * row, column, context);
    });
  }

  void trace_packet(const Rays& rays, std::size_t row, std::size_t column, RTCIntersectContext& context) {
    RTCRayHit16 packet;
    alignas(64) std::array<int, 16> valid{};
    for (unsigned i = 0; i < 16; ++i) {
      const auto y = static_cast<float>(static_cast<unsigned>(row) + i / 4);
      const auto x = static_cast<float>(static_cast<unsigned>(column) + i % 4);
      valid[i] = y < static_cast<float>(size_) && x < static_cast<float>(size_) ? -1 : 0;
      packet.ray.org_x[i] = rays.eye[0];
      packet.ray.org_y[i] = rays.eye[1];
      packet.ray.org_z[i] = rays.eye[2];
      packet.ray.dir_x[i] = rays.first[0] + y * rays.down[0] + x * rays.right[0];
      packet.ray.dir_y[i] = rays.first[1] + y * rays.down[1] + x * rays.right[1];
      packet.ray.dir_z[i] = rays.first[2] + y * rays.down[2] + x * rays.right[2];
      packet.ray.tnear[i] = rays.near;
      packet.ray.tfar[i] = rays.far;
      packet.ray.time[i] = 0;
      packet.ray.mask[i] = ~0U;
      packet.ray.flags[i] = 0;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid.data(), rays_, &context, &packet);
    for (std::size_t i = 0; i < 16; ++i) {
      if (valid[i] == 0) continue;
      const std::size_t sample = (row + i / 4) * size_ + column + i % 4;
      const bool is_hit = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
      face_[sample] = is_hit ? static_cast<std::int32_t>(packet.hit.primID[i]) : -1;
      barycentric_[2 * sample] = packet.hit.u[i];
      barycentric_[2 * sample + 1] = packet.hit.v[i];
    }
  }

  const Scene& scene_;
  std::size_t size_;
  RTCDevice device_;
  RTCScene rays_;
  std::vector<std::int32_t> face_;
  std::vector<float> barycentric_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::EmbreeRenderer>(argc, argv, "ignored");
}

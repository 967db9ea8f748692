#pragma once
#include <tapestry/camouflage/training.hpp>
#include <tapestry/io/darknet/model_file.hpp>

namespace tapestry::test {
/// A box on wheels reduced to the box: 12 faces, all painted but the bottom, uv one to one on a 2×1 atlas.
inline raster::PaintedMesh tiny_car(std::size_t texel_rows = 12,
                                    raster::TextureKind kind = raster::TextureKind::atlas) {
  raster::PaintedMesh car;
  auto& mesh = car.mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(
        {(i & 1) != 0 ? 2.0 : -2.0, (i & 2) != 0 ? 0.9 : -0.9, (i & 4) != 0 ? 1.4 : 0.1});
  const std::vector<std::array<std::int32_t, 4>> sides{{1, 3, 7, 5}, {2, 0, 4, 6}, {3, 2, 6, 7},
                                                       {0, 1, 5, 4}, {4, 5, 7, 6}, {2, 3, 1, 0}};
  mesh.materials = {{"body", {0.3F, 0.5F, 0.7F}}, {"floor", {0.1F, 0.1F, 0.1F}}};
  for (std::size_t side = 0; side < sides.size(); ++side) {
    const auto first = static_cast<std::int32_t>(mesh.uvs.size());
    const double left = 2.0 * static_cast<double>(side) / 6;
    const double right = left + 2.0 / 6;
    mesh.uvs.insert(mesh.uvs.end(), {{left, 0.0}, {right, 0.0}, {right, 1.0}, {left, 1.0}});
    const auto& q = sides[side];
    mesh.faces.push_back({q[0], q[1], q[2]});
    mesh.faces.push_back({q[0], q[2], q[3]});
    mesh.face_uvs.push_back({first, first + 1, first + 2});
    mesh.face_uvs.push_back({first, first + 2, first + 3});
    for (int k = 0; k < 2; ++k) {
      mesh.face_normals.push_back({-1, -1, -1});
      mesh.face_groups.push_back(-1);
      mesh.face_materials.push_back(side == 5 ? 1 : 0);
    }
  }
  car.painted = geometry::faces_by_material(mesh, {"body"});
  car.layout.kind = kind;
  car.layout.height = texel_rows;
  car.layout.width = 2 * texel_rows;
  car.layout.u_extent = 2;
  car.layout.texels_per_edge = 4;
  return car;
}

/// A frame of noise of the given size, seen from around the car.
inline io::Frame tiny_frame(std::size_t number, std::size_t size = 48) {
  io::Frame frame;
  frame.name = "frame" + std::to_string(number);
  frame.image = Array<std::uint8_t, 3>(Extents<3>{size, size, 3});
  Random random(100 + number);
  for (auto& value : frame.image.storage()) value = static_cast<std::uint8_t>(random.index(256));
  frame.camera = geometry::orbit_camera(0.4 + 2.1 * static_cast<double>(number), 0.35, 6, {0, 0, 0.7}, 0.9);
  frame.light = raster::Light{0.45, 0.5, {0.3, 0.4, 0.8}, {1, 0.95, 0.9}};
  return frame;
}

/// A YOLO-V3 in small: three scales, residual shortcut, routes, upsampling; 48 × 48 input, 2 classes.
inline std::string tiny_network_text(const std::string& activation = "leaky") {
  const auto conv = [&](int filters, int size, int stride) {
    return "[convolutional]\nbatch_normalize=1\nfilters=" + std::to_string(filters) +
           "\nsize=" + std::to_string(size) + "\nstride=" + std::to_string(stride) +
           "\npad=1\nactivation=" + activation + "\n\n";
  };
  const auto head = [](const std::string& mask) {
    return "[convolutional]\nfilters=14\nsize=1\nstride=1\npad=1\nactivation=linear\n\n"
           "[yolo]\nmask=" +
           mask + "\nanchors=6,6, 12,10, 16,22, 24,18, 34,26, 44,40\nclasses=2\nnum=6\n\n";
  };
  return "[net]\nwidth=48\nheight=48\nchannels=3\n\n" + conv(6, 3, 2) + conv(8, 3, 2) + conv(8, 3, 1) +
         "[shortcut]\nfrom=-2\nactivation=linear\n\n" + conv(12, 3, 2) + conv(16, 3, 2) + head("4,5") +
         "[route]\nlayers=-3\n\n" + conv(6, 1, 1) + "[upsample]\nstride=2\n\n[route]\nlayers=-1,4\n\n" +
         conv(10, 3, 1) + head("2,3") + "[route]\nlayers=-3\n\n" + conv(6, 1, 1) +
         "[upsample]\nstride=2\n\n[route]\nlayers=-1,3\n\n" + conv(8, 3, 1) + head("0,1");
}

template <class T>
detect::DarknetModel<T> tiny_model(const std::string& activation = "leaky", std::uint64_t seed = 5) {
  detect::DarknetModel<T> model(io::parse_network_config(tiny_network_text(activation), "tiny.cfg"));
  Random random(seed);
  model.initialise(random);
  return model;
}

template <class T>
detect::Detector<T> tiny_detector(const std::string& activation = "leaky", std::uint64_t seed = 5) {
  return tiny_model<T>(activation, seed).detector();
}

/// Gives every weight of a detector the value NaN.
template <class T>
void spoil(detect::Detector<T>& detector) {
  detector.set_weights(filled<T, 1>({detector.weights().size()}, std::numeric_limits<T>::quiet_NaN()));
}

/// Views of the frames load(0), load(1), ….
template <class T, class Load>
camouflage::ViewStore<T> tiny_store(const raster::PaintedMesh& car, std::size_t count,
                                    const typename camouflage::ViewStore<T>::Settings& settings, Load load) {
  std::vector<typename camouflage::ViewStore<T>::Loader> loaders;
  for (std::size_t i = 0; i < count; ++i) loaders.push_back([load, i] { return load(i); });
  return {car, settings, std::move(loaders)};
}
template <class T>
camouflage::ViewStore<T> tiny_store(const raster::PaintedMesh& car, std::size_t count) {
  return tiny_store<T>(car, count, {48, 48, 2}, [](std::size_t i) { return tiny_frame(i); });
}
}  // namespace tapestry::test

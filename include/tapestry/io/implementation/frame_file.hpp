#pragma once
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/implementation/frame_members.hpp>

namespace tapestry::io {
namespace detail {
/// Files of a frame in three parts: JSON, picture, mask.
struct FrameParts {
  std::string json, picture, mask;

  explicit FrameParts(const std::string& path) : json(path) {
    const std::filesystem::path place = path_of(path);
    const std::string name = place.stem().string() + ".png";
    picture = (place.parent_path() / name).string();
    mask = (place.parent_path() / "masks" / name).string();
  }
};

/// A mask of a file: 1 for any level but 0.
inline Array<std::uint8_t, 2> read_mask_part(const FrameParts& parts, const Frame& frame) {
  const auto grey = io::read_mask(parts.mask);
  const std::array<std::size_t, 2> picture{frame.image.shape(0), frame.image.shape(1)};
  if (grey.shape() != picture)
    throw file_mismatch({parts.mask, "", "mask of another size than " + parts.picture, shape_text(picture),
                         shape_text(grey.shape())});
  Array<std::uint8_t, 2> mask(grey.shape());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const float level = grey.data()[i];
    mask.data()[i] = level > 0 ? static_cast<std::uint8_t>(std::max(std::lround(255 * level), 1L)) : 0;
  }
  return mask;
}

inline Frame read_frame_parts(const std::string& path) {
  const FrameParts parts(path);
  const NpzFile members = read_json_members(path);
  if (!is_there(parts.picture)) throw file_mismatch({path, "", "no picture beside the frame", parts.picture});
  Frame frame;
  frame.name = path;
  frame.image = read_image(parts.picture, &frame.warnings);
  read_members(members, frame);
  if (is_there(parts.mask)) frame.mask = read_mask_part(parts, frame);
  return frame;
}

/// Calls add(name, shape, numbers) for everything but picture, mask and label.
template <class Add>
void visit_members(const Frame& frame, Add add) {
  const auto add_pose = [&](const char* name, const geometry::Vector3& t, const geometry::Vector3& r) {
    add(name, std::vector<std::size_t>{2, 3}, std::vector<double>{t[0], t[1], t[2], r[0], r[1], r[2]});
  };
  const geometry::CarlaPose pose = frame.pose.value_or(geometry::CarlaPose{});
  add_pose("veh_trans", pose.vehicle_translation, pose.vehicle_rotation_deg);
  add_pose("cam_trans", pose.camera_translation, pose.camera_rotation_deg);
  if (frame.camera) {
    std::vector<double> matrix;
    for (std::size_t row = 0; row < 3; ++row) {
      matrix.insert(matrix.end(), frame.camera->rotation[row].begin(), frame.camera->rotation[row].end());
      matrix.push_back(frame.camera->translation[row]);
    }
    add("camera_matrix", std::vector<std::size_t>{3, 4}, matrix);
    add("camera_fov", std::vector<std::size_t>{2},
        std::vector<double>{frame.camera->tan_half_fov_x, frame.camera->tan_half_fov_y});
  }
  if (frame.light) {
    const auto& [ambient, directional, direction, colour] = *frame.light;
    add("light", std::vector<std::size_t>{8},
        std::vector<double>{ambient, directional, direction[0], direction[1], direction[2], colour[0],
                            colour[1], colour[2]});
  }
}

template <class Add>
void visit_label(const Frame& frame, Add add) {
  if (!frame.label) return;
  const auto height = static_cast<double>(frame.image.shape(0));
  const auto width = static_cast<double>(frame.image.shape(1));
  const auto& [class_index, box] = *frame.label;
  add("label", std::vector<std::size_t>{5},
      std::vector<double>{static_cast<double>(class_index), box.cx / width, box.cy / height, box.w / width,
                          box.h / height});
}

inline void write_frame_parts(const std::string& path, const Frame& frame) {
  const FrameParts parts(path);
  nlohmann::ordered_json json{{"format", frame_format}};
  const auto add = [&](const std::string& name, const std::vector<std::size_t>& shape,
                       const std::vector<double>& numbers) {
    if (!frame.pose && name.ends_with("_trans")) return;
    if (shape.size() == 1) {
      json[name] = numbers;
      return;
    }
    for (std::size_t row = 0; row < shape[0]; ++row) {
      const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(row * shape[1]);
      json[name].push_back(std::vector<double>(first, first + static_cast<std::ptrdiff_t>(shape[1])));
    }
  };
  visit_members(frame, add);
  visit_label(frame, add);
  write_image(parts.picture, frame.image);
  if (frame.mask) {
    std::error_code ignored;  // the writer names the folder
    std::filesystem::create_directory(path_of(parts.mask).parent_path(), ignored);
    Array<float, 2> levels(frame.mask->shape());
    for (std::size_t i = 0; i < levels.size(); ++i)
      levels.data()[i] = static_cast<float>(frame.mask->data()[i]) / 255;
    write_mask(parts.mask, levels);
  }
  write_file_atomically(path, json.dump(1) + "\n");
}

/// Key that sorts file names with numbers by value: each number with zeros before it, to at least 20 digits.
inline std::string numeric_order_key(const std::string& path) {
  std::string key;
  const std::string stem = path_of(path).stem().string();
  for (std::size_t i = 0; i < stem.size();) {
    std::size_t end = i;
    while (end < stem.size() && stem[end] >= '0' && stem[end] <= '9') ++end;
    if (end > i) key += std::string(20 - std::min<std::size_t>(20, end - i), '0');
    end = std::max(end, i + 1);
    key += stem.substr(i, end - i);
    i = end;
  }
  return key;
}
}  // namespace detail

Frame read_frame(const std::string& path) {
  if (path.ends_with(".json")) return detail::read_frame_parts(path);
  const NpzFile file = NpzFile::read(path);
  Frame frame;
  frame.name = path;
  const NpyArray& picture = file.get("img");
  if (picture.type != DType::u1 || picture.shape.size() != 3 || picture.shape[2] != 3 ||
      picture.size() == 0) {
    throw file_mismatch({path, "", "member 'img' is no colour picture", "u1 (height, width, 3)",
                         std::string(type_name(picture.type)) + " " + shape_text(picture.shape)});
  }
  frame.image = image::swap_red_blue(picture.array<std::uint8_t, 3>());
  detail::read_members(file, frame);
  if (file.has("mask")) frame.mask = detail::read_mask(file, frame.image.shape(0), frame.image.shape(1));
  return frame;
}

std::vector<std::string> frame_files(const std::string& path) {
  if (!path.ends_with(".json")) return {path};
  const detail::FrameParts parts(path);
  std::vector<std::string> files{parts.json, parts.picture};
  if (is_there(parts.mask)) files.push_back(parts.mask);
  return files;
}

Array<std::uint8_t, 3> read_picture(const std::string& path, std::vector<std::string>* warnings) {
  const bool is_frame = path.ends_with(".npz") || path.ends_with(".json");
  return is_frame ? read_frame(path).image : read_image(path, warnings);
}

void write_frame(const std::string& path, const Frame& frame) {
  const auto& extents = frame.image.shape();
  if (extents[2] != 3 || frame.image.size() == 0) throw ShapeError("write_frame: image is not [H, W, 3]");
  if (frame.mask) require_shape("write_frame", "mask", *frame.mask, {extents[0], extents[1]});
  if (path.ends_with(".json")) return detail::write_frame_parts(path, frame);
  NpzWriter writer;
  writer.add("img", image::swap_red_blue(frame.image));
  const auto add = [&](const char* name, const std::vector<std::size_t>& shape,
                       const std::vector<double>& numbers) {
    writer.add(name, std::span<const std::size_t>(shape), std::span<const double>(numbers));
  };
  detail::visit_members(frame, add);
  if (frame.mask) writer.add("mask", *frame.mask);
  detail::visit_label(frame, add);
  writer.write(path, true);
}

std::vector<std::string> frame_paths(const std::string& folder) {
  const auto listed = [&](const char* extension) {
    return listed_paths(folder,
                        [=](const std::filesystem::path& path) { return path.extension() == extension; });
  };
  auto paths = listed(".npz");
  if (paths.empty()) paths = listed(".json");
  if (paths.empty()) throw file_mismatch({folder, "", "holds no frame (*.npz, or *.json with pictures)"});
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return std::pair(detail::numeric_order_key(a), a) < std::pair(detail::numeric_order_key(b), b);
  });
  return paths;
}
}  // namespace tapestry::io

#pragma once
#include <tapestry/raster/detail/vertex_gradient/grazing_faces.hpp>
#include <tuple>

namespace tapestry::raster::detail {
/// A face that may be one of a large plane.
struct GrazingFace {
  std::int32_t face = -1;
  double area = 0;                ///< px², as if it lay across the ray to its farthest corner
  double cosine = 1;              ///< of its normal and that ray
  std::array<double, 4> plane{};  ///< unit normal, away from the eye, and distance from the eye
};

/// Sets all members if a face is seen nearly edge-on, at its farthest corner and in the middle of its part of
/// the picture; returns whether it is.
[[nodiscard]] inline bool set_grazing(const FacesInView& faces, std::size_t face, GrazingFace& found) {
  constexpr double most_cosine = 0.1;
  const auto corners = faces.corners(face);
  const auto normal =
      geometry::cross(geometry::subtract(corners[1], corners[0]), geometry::subtract(corners[2], corners[0]));
  const double height = geometry::dot(normal, corners[0]), size_squared = geometry::dot(normal, normal);
  double squared = 0;
  for (const geometry::Vector3& corner : corners) squared = std::max(squared, geometry::dot(corner, corner));
  const double least = most_cosine * most_cosine * size_squared;
  if (!(height * height < least * squared)) return false;
  const FacesInView::Box box = faces.box(face);
  const auto middle = [&](std::size_t axis) {
    return static_cast<double>(box.low[axis] + box.high[axis]) / 2;
  };
  const geometry::Vector3 ray = faces.frame().rays.at(middle(0), middle(1));
  const double slope = geometry::dot(normal, ray);
  if (!(slope * slope < least * geometry::dot(ray, ray))) return false;
  const double size = std::sqrt(size_squared), scale = (height < 0 ? -1 : 1) / size;
  const auto& step = faces.frame().rays.step;
  found = {static_cast<std::int32_t>(face),
           size / (2 * squared * step[0] * step[1]),
           std::abs(height) / (size * std::sqrt(squared)),
           {scale * normal[0], scale * normal[1], scale * normal[2], scale * height}};
  return std::isfinite(found.area);
}

/// All faces seen nearly edge-on.
[[nodiscard]] inline std::vector<GrazingFace> all_grazing(const FacesInView& faces) {
  constexpr std::size_t block = 4096;
  const std::size_t count = faces.mesh().faces.size();
  std::vector<std::vector<GrazingFace>> blocks(block_count(count, block));
  parallel_for(blocks.size(), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, count, block);
    GrazingFace found;
    for (std::size_t face = begin; face < end; ++face)
      if (faces.winding(static_cast<std::int32_t>(face)) != 0 && set_grazing(faces, face, found))
        blocks[index].push_back(found);
  });
  std::vector<GrazingFace> all;
  for (const auto& found : blocks) all.insert(all.end(), found.begin(), found.end());
  return all;
}

std::vector<std::int32_t> grazing_faces(const FacesInView& faces, double sample_distance) {
  constexpr double plane_step = 0.01;   // of planes that count as one
  constexpr double least_share = 0.04;  // of the picture's part that faces may touch
  const double most_thickness = std::max(8 * sample_distance, 2.0);
  auto all = all_grazing(faces);
  double farthest = 0;
  for (const GrazingFace& one : all) farthest = std::max(farthest, one.plane[3] / one.cosine);
  for (GrazingFace& one : all) {
    if (farthest > 0) one.plane[3] /= farthest;
    for (double& value : one.plane) value = std::round(value / plane_step);
  }
  std::sort(all.begin(), all.end(), [](const GrazingFace& a, const GrazingFace& b) {
    return std::tie(a.plane, a.face) < std::tie(b.plane, b.face);
  });
  std::vector<std::int32_t> kept;
  const double least_area = least_share * faces.extent().box.area();
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    double area = 0, seen_area = 0;
    for (end = begin; end < all.size() && all[end].plane == all[begin].plane; ++end) {
      area += all[end].area;
      seen_area += all[end].area * all[end].cosine;
    }
    if (area < least_area || seen_area > most_thickness * std::sqrt(area)) continue;
    for (std::size_t i = begin; i < end; ++i) kept.push_back(all[i].face);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

GrazingSpans::GrazingSpans(const std::vector<std::int32_t>& faces) {
  for (const std::int32_t face : faces) faces_.push_back({face});
}

void GrazingSpans::find(FaceField& field) {
  parallel_for(faces_.size(), [&](std::size_t index) {
    Face& own = faces_[index];
    const auto face = static_cast<std::size_t>(own.face);
    if (field.faces().winding(own.face) == 0 || !own.weights.set(field.rays(), field.faces().corners(face)))
      return;
    double along_row = 0, along_column = 0;
    for (const Affine& weight : own.weights.w) {
      along_row = std::max(along_row, std::abs(weight.a));
      along_column = std::max(along_column, std::abs(weight.b));
    }
    own.axis = along_row > along_column ? 0 : 1;
    const FacesInView::Box box = field.faces().box(face);
    const auto low = static_cast<double>(box.low[1 - own.axis]);
    const auto high = static_cast<double>(box.high[1 - own.axis]);
    for (double line = std::floor(low * lines_a_pixel); line < high * lines_a_pixel; ++line)
      find_along(field, {own.axis, (line + 0.5) / lines_a_pixel}, own);
  });
  for (Face& own : faces_)
    for (Span& span : own.spans) {
      const PictureLine line{own.axis, span.place};
      span.line = field.mark(line.at(span.range.begin), line.at(span.range.end));
    }
}

/// Finds the parts of one line that may be visible.
void GrazingSpans::find_along(const FaceField& field, const PictureLine& line, Face& own) {
  const auto& size = field.faces().frame().size;
  Range range{0, size[own.axis]};
  for (const Affine& weight : own.weights.w) line.keep(weight, range);
  const Affine depth = own.weights.inverse_depth();
  line.keep({depth.a, depth.b, depth.c - field.limits()[0]}, range);
  line.keep({-depth.a, -depth.b, field.limits()[1] - depth.c}, range);
  if (!(range.begin < range.end)) return;
  std::vector<Range> parts;
  for (double border = std::floor(range.begin); border < range.end; ++border) {
    const auto [column, row] = line.at(border);
    const auto pixel = static_cast<std::size_t>(std::floor(row) * size[0] + std::floor(column));
    parts.assign(1, {std::max(range.begin, border), std::min(range.end, border + 1)});
    for (const std::int32_t hider : field.seen_in(pixel))
      hide(field, own, hider, field.weights(hider), line, parts);
    for (const Range& part : parts) own.spans.push_back({pixel, line.place, part});
  }
}

/// Removes the faces that one hides; of faces in one place, the lower index is seen. Two faces compare their
/// 1/z by the same numbers: rounding never hides both.
void GrazingSpans::hide(const FaceField& field, const Face& own, std::int32_t hider,
                        const FaceWeights& weights, const PictureLine& line, std::vector<Range>& parts) {
  if (hider == own.face || parts.empty()) return;
  const Affine depth = own.weights.inverse_depth(), its = weights.inverse_depth();
  const Affine nearer{its.a - depth.a, its.b - depth.b, its.c - depth.c};
  if (nearer.a == 0 && nearer.b == 0 && nearer.c == 0 && hider > own.face) return;
  Range gone = parts.front();
  for (const Range& part : parts) gone = {std::min(gone.begin, part.begin), std::max(gone.end, part.end)};
  for (const Affine& function :
       {weights.w[0], weights.w[1], weights.w[2], nearer, Affine{its.a, its.b, its.c - field.limits()[0]},
        Affine{-its.a, -its.b, field.limits()[1] - its.c}}) {
    line.keep(function, gone);
    if (!(gone.begin < gone.end)) return;
  }
  for (std::size_t i = parts.size(); i-- > 0;) {
    const Range part = parts[i];
    if (gone.end <= part.begin || part.end <= gone.begin) continue;
    if (gone.end < part.end) parts.push_back({gone.end, part.end});
    parts[i].end = gone.begin;
    if (!(part.begin < gone.begin)) parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

/// Finds the parts of a span that no face hides.
void GrazingSpans::find_visible(const FaceField& field, const Face& own, const Span& span,
                                std::vector<Range>& parts) {
  const PictureLine line{own.axis, span.place};
  parts.assign(1, span.range);
  field.for_each_face_near(span.line, [&](std::int32_t face, const FaceWeights& weights) {
    hide(field, own, face, weights, line, parts);
  });
}
}  // namespace tapestry::raster::detail

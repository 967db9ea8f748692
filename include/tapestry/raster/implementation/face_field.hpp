#pragma once
#include <tapestry/raster/detail/face_field.hpp>

namespace tapestry::raster {

FaceField::FaceField(const FacesInView& faces, const SeenFaces& seen, const geometry::Camera& camera)
    : faces_(faces),
      seen_(seen),
      limits_{1 / camera.far, 1 / camera.near},
      grid_(faces.extent()),
      place_(grid_.size() + 1, 0),
      listed_(1),
      slot_(faces.mesh().faces.size(), 0) {
  for (const SeenFaces::Band& band : seen.bands())
    for (const std::int32_t face : band.faces()) {
      if (slot_[static_cast<std::size_t>(face)] != 0 || faces_.winding(face) == 0) continue;
      Listed own{{}, face};
      if (own.weights.set(rays(), faces_.corners(static_cast<std::size_t>(face)))) keep(own);
    }
}

void FaceField::mark(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  grid_.for_each_cell_along(from, to, 2e-5, [&](std::size_t cell) {
    std::atomic_ref(place_[cell]).store(1, std::memory_order_relaxed);
  });
}

void FaceField::fill() {
  std::uint32_t count = 0;
  for (std::uint32_t& place : place_)
    if (place != 0) place = ++count;
  list_faces(count);
  sort_cells();
}

void FaceField::keep_near(const std::array<double, 2>& from, const std::array<double, 2>& to,
                          const std::array<double, 2>& step, std::span<const CellEntry> faces,
                          std::vector<CellEntry>& kept) const {
  kept.clear();
  for (const CellEntry entry : faces) {
    const auto& w = listed_[entry.slot()].weights.w;
    const bool is_near = std::all_of(w.begin(), w.end(), [&](const Affine& part) {
      const double reach = 2 * std::abs(part.a * step[0] + part.b * step[1]);
      return std::max(part.at(from[0], from[1]), part.at(to[0], to[1])) + reach >= 0;
    });
    if (is_near) kept.push_back(entry);
  }
}

bool FaceField::has_marks(const CellGrid::Range& range) const {
  for (std::int32_t y = range.first[1]; y <= range.last[1]; ++y)
    for (std::int32_t x = range.first[0]; x <= range.last[0]; ++x)
      if (place_[grid_.index(x, y)] != 0) return true;
  return false;
}

void FaceField::list_face(std::size_t face, Block& block) const {
  constexpr double pad = 1e-4, rounding = 1.2e-7;  // margins for the box, which is in float
  const FacesInView::Box box = faces_.box(face);
  std::array<double, 2> low, high;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    low[axis] = static_cast<double>(box.low[axis]) * (1 - rounding) - pad;
    high[axis] = static_cast<double>(box.high[axis]) * (1 + rounding) + pad;
  }
  const CellGrid::Range range = grid_.cells_of(low, high);
  if (!has_marks(range)) return;
  const auto corners = faces_.corners(face);
  const bool is_known = slot_[face] != 0;
  FaceWeights weights = listed_[slot_[face]].weights;
  if (!is_known && !weights.set(rays(), corners)) return;
  const auto& w = weights.w;
  const double depth = std::min({corners[0][2], corners[1][2], corners[2][2]});
  const double most = std::min((1 + 1e-9) / std::max(depth, 0.0), limits_[1]);  // 1/z
  const double reach = grid_.side() / 2 + pad;
  std::array<double, 3> change;  // largest change of each weight within a cell
  for (std::size_t k = 0; k < 3; ++k) change[k] = reach * (std::abs(w[k].a) + std::abs(w[k].b));
  const Affine inverse_depth = weights.inverse_depth();
  const double depth_change = reach * (std::abs(inverse_depth.a) + std::abs(inverse_depth.b));
  const std::size_t found_before = block.found.size();
  for (std::int32_t y = range.first[1]; y <= range.last[1]; ++y) {
    for (std::int32_t x = range.first[0]; x <= range.last[0]; ++x) {
      const std::uint32_t place = place_[grid_.index(x, y)];
      if (place == 0) continue;
      const auto [column, row] = grid_.middle(x, y);
      const double w0 = w[0].at(column, row), w1 = w[1].at(column, row), w2 = w[2].at(column, row);
      if (w0 < -change[0] || w1 < -change[1] || w2 < -change[2]) continue;
      const double nearest = std::min(most, w0 + w1 + w2 + depth_change);
      block.found.push_back({place, CellEntry::farness_of(nearest), static_cast<std::int32_t>(face)});
    }
  }
  if (is_known || block.found.size() == found_before) return;
  block.listed.push_back({weights, static_cast<std::int32_t>(face)});
}

void FaceField::list_faces(std::size_t cell_count) {
  const std::size_t face_count = faces_.mesh().faces.size();
  constexpr std::size_t block = 4096;
  std::vector<Block> blocks(block_count(face_count, block));
  parallel_for(cell_count == 0 ? 0 : blocks.size(), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, face_count, block);
    for (std::size_t face = begin; face < end; ++face)
      if (faces_.winding(static_cast<std::int32_t>(face)) != 0) list_face(face, blocks[index]);
  });
  begin_.assign(cell_count + 2, 0);
  for (const Block& done : blocks)
    for (const Found& one : done.found) ++begin_[one.cell + 1];
  for (std::size_t cell = 0; cell + 1 < begin_.size(); ++cell) begin_[cell + 1] += begin_[cell];
  entries_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  std::size_t size = listed_.size();
  for (const Block& done : blocks) size += done.listed.size();
  listed_.reserve(size);
  for (Block& done : blocks) {
    for (const Listed& listed : done.listed) keep(listed);
    for (const Found& one : done.found)
      entries_[next[one.cell]++] = CellEntry::of(one.farness, slot_[static_cast<std::size_t>(one.face)]);
    done = {};
  }
}

void FaceField::keep(const Listed& listed) {
  slot_[static_cast<std::size_t>(listed.face)] = static_cast<std::uint32_t>(listed_.size());
  listed_.push_back(listed);
}

void FaceField::sort_cells() {
  constexpr std::size_t block = 1024;
  const std::size_t cell_count = begin_.size() - 1;
  parallel_for(block_count(cell_count, block), [&](std::size_t index) {
    const auto [first, last] = block_range(index, cell_count, block);
    for (std::size_t cell = first; cell < last; ++cell)
      std::sort(entries_.data() + begin_[cell], entries_.data() + begin_[cell + 1]);
  });
}

}  // namespace tapestry::raster

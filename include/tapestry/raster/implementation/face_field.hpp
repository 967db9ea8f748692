#pragma once
#include <tapestry/raster/detail/face_field.hpp>

namespace tapestry::raster {
FaceField::FaceField(const FacesInView& faces, const SeenFaces& seen, const geometry::Camera& camera)
    : faces_(faces),
      seen_(seen),
      limits_{1 / camera.far, 1 / camera.near},
      grid_(faces.extent()),
      listed_(1),
      slot_(faces.mesh().faces.size(), 0) {
  seen.for_each_face([&](std::int32_t face) {
    if (slot_[static_cast<std::size_t>(face)] != 0 || faces_.winding(face) == 0) return;
    Listed own{{}, face};
    if (own.weights.set(rays(), faces_.corners(static_cast<std::size_t>(face)))) keep(own);
  });
}

void FaceField::fill() {
  cut_lines();
  list_faces();
}

void FaceField::look(std::size_t segment, const std::array<double, 2>& step,
                     std::span<const HalfEdge> left_out, LinePoints& points,
                     std::vector<LineFace>& found) const {
  found.clear();
  for (const std::uint32_t slot : near(segment)) {
    const Listed& listed = listed_[slot];
    const auto is_own = [&](const HalfEdge& half) { return half.face == listed.face; };
    if (std::any_of(left_out.begin(), left_out.end(), is_own)) continue;
    LineFace& own = found.emplace_back();
    own.face = static_cast<double>(listed.face);
    for (std::size_t k = 0; k < 3; ++k) {
      const Affine& w = listed.weights.w[k];
      own.w[k] = {w.a, w.b, w.c};
      own.change[k] = w.a * step[0] + w.b * step[1];
    }
  }
  raster_kernels().look_along(found.data(), found.size(), limits_, points);
}

/// Cuts the lines at the borders of cells, and sorts the segments by cell.
void FaceField::cut_lines() {
  std::vector<Line> segments;
  std::vector<std::uint32_t> cells;
  for (const Line& line : lines_) {
    first_.push_back(segments.size());
    grid_.cut(line.from, line.to, [&](std::size_t cell, const auto& from, const auto& to) {
      segments.push_back({from, to});
      cells.push_back(static_cast<std::uint32_t>(cell));
      end_.push_back(distance(line.from, to));
    });
  }
  first_.push_back(segments.size());
  deal_out(cells, segments);
}

void FaceField::deal_out(const std::vector<std::uint32_t>& cell_of_segment,
                         const std::vector<Line>& segments) {
  cell_begin_.assign(grid_.size() + 1, 0);
  for (const std::uint32_t cell : cell_of_segment) ++cell_begin_[cell + 1];
  for (std::size_t cell = 1; cell < cell_begin_.size(); ++cell) cell_begin_[cell] += cell_begin_[cell - 1];
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  place_.resize(segments.size());
  constexpr std::size_t beyond = 8;  // elements that kernels read past the last one
  for (std::vector<double>& end : ends_) end.assign(segments.size() + beyond, 0);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    place_[i] = next[cell_of_segment[i]]++;
    const auto& [from, to] = segments[i];
    for (std::size_t axis = 0; axis < 2; ++axis) {
      ends_[axis][place_[i]] = from[axis];
      ends_[2 + axis][place_[i]] = to[axis];
    }
  }
}

/// The first and the last of some cells of a row that a face may touch; the last is less if there are none.
std::array<std::int32_t, 2> FaceField::touched(const FaceWeights& weights, std::int32_t first,
                                               std::int32_t last, std::int32_t row) const {
  const double reach = grid_.side() / 2 + margin;
  const auto touches = [&](std::int32_t x) {
    const auto [column, middle_row] = grid_.middle(x, row);
    return std::all_of(weights.w.begin(), weights.w.end(), [&, c = column, r = middle_row](const Affine& w) {
      return w.at(c, r) >= -reach * (std::abs(w.a) + std::abs(w.b));
    });
  };
  if (last - first < 3) return {first, last};
  while (first <= last && !touches(first)) ++first;
  while (first < last && !touches(last)) --last;
  return {first, last};
}

/// Lists the segments that a face may touch.
void FaceField::list_face(std::size_t face, Block& block) const {
  constexpr double rounding = 1.2e-7;  // of the box, which is in float
  const FacesInView::Box box = faces_.box(face);
  std::array<double, 2> low, high;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    low[axis] = static_cast<double>(box.low[axis]) * (1 - rounding) - margin;
    high[axis] = static_cast<double>(box.high[axis]) * (1 + rounding) + margin;
  }
  const CellGrid::Range range = grid_.cells_of(low, high);
  const auto first_place = [&](std::int32_t x, std::int32_t y) { return cell_begin_[grid_.index(x, y)]; };
  Listed own;
  FaceReach reach;
  const std::size_t before = block.places.size();
  std::size_t size = before;
  for (std::int32_t y = range.first[1]; y <= range.last[1]; ++y) {
    if (first_place(range.first[0], y) == first_place(range.last[0] + 1, y)) continue;
    if (own.face < 0) {
      own = {listed_[slot_[face]].weights, static_cast<std::int32_t>(face)};
      if (slot_[face] == 0 && !own.weights.set(rays(), faces_.corners(face))) return;
      for (std::size_t k = 0; k < 3; ++k) {
        const Affine& w = own.weights.w[k];
        reach.w[k] = {w.a, w.b, w.c};
        reach.margin[k] = margin * (std::abs(w.a) + std::abs(w.b));
      }
    }
    const auto [first, last] = touched(own.weights, range.first[0], range.last[0], y);
    const std::uint32_t begin = first_place(first, y), end = first_place(last + 1, y);
    if (begin >= end) continue;
    block.places.resize(size + end - begin + 8);  // the kernel writes beyond
    size += raster_kernels().near_segments(
        reach, {ends_[0].data(), ends_[1].data(), ends_[2].data(), ends_[3].data()}, begin, end,
        block.places.data() + size);
  }
  block.places.resize(size);
  if (size == before) return;
  block.found.push_back({own.face, static_cast<std::uint32_t>(size - before)});
  if (slot_[face] == 0) block.listed.push_back(own);
}

void FaceField::list_faces() {
  const std::size_t face_count = faces_.mesh().faces.size();
  constexpr std::size_t block = 4096;
  std::vector<Block> blocks(block_count(face_count, block));
  parallel_for(place_.empty() ? 0 : blocks.size(), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, face_count, block);
    for (std::size_t face = begin; face < end; ++face)
      if (faces_.winding(static_cast<std::int32_t>(face)) != 0) list_face(face, blocks[index]);
  });
  begin_.assign(place_.size() + 2, 0);
  for (const Block& done : blocks)
    for (const std::uint32_t place : done.places) ++begin_[place + 2];
  for (std::size_t place = 2; place < begin_.size(); ++place) begin_[place] += begin_[place - 1];
  near_.resize(begin_.back());
  std::size_t size = listed_.size();
  for (const Block& done : blocks) size += done.listed.size();
  listed_.reserve(size);
  for (Block& done : blocks) {
    for (const Listed& listed : done.listed) keep(listed);
    const std::uint32_t* place = done.places.data();
    for (const auto& [face, count] : done.found) {
      const std::uint32_t slot = slot_[static_cast<std::size_t>(face)];
      for (const std::uint32_t* const end = place + count; place != end; ++place)
        near_[begin_[*place + 1]++] = slot;
    }
    done = {};
  }
}

void FaceField::keep(const Listed& listed) {
  slot_[static_cast<std::size_t>(listed.face)] = static_cast<std::uint32_t>(listed_.size());
  listed_.push_back(listed);
}
}  // namespace tapestry::raster

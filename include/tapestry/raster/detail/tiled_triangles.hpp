#pragma once
#include <memory>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/detail/triangle_setup.hpp>

namespace tapestry::raster {
/// Throws Error (mismatch) naming the face unless every corner of every face exists.
inline void require_corners(const char* operation, const geometry::Mesh& mesh) {
  if (mesh.faces.empty() ||
      raster_kernels().highest_index(mesh.faces[0].data(), 3 * mesh.faces.size()) < mesh.positions.size())
    return;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (const std::int32_t corner : mesh.faces[face]) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= mesh.positions.size())
        throw Error(ErrorKind::mismatch, {operation, ": face ", face, " refers to position ", corner, " of ",
                                          mesh.positions.size()});
    }
  }
}

/// The faces of a mesh that touch one view, as triangles in lists of the tiles of its grid of samples. Faces
/// whose box lies between samples, and faces without area after snapping, have none.
class TiledTriangles {
 public:
  /// \throws Error (mismatch) if a face refers to a missing position
  TiledTriangles(const char* operation, const geometry::Mesh& mesh, const geometry::Camera& camera,
                 std::size_t sample_rows, std::size_t sample_columns, FaceCulling culling,
                 const RasterKernels& kernels = raster_kernels())
      : kernels_(kernels),
        sample_rows_(sample_rows),
        sample_columns_(sample_columns),
        tile_rows_(block_count(sample_rows, tile_height)),
        tile_columns_(block_count(sample_columns, tile_width)),
        positions_view_(mesh.positions.size()) {
    std::unique_ptr<ScreenVertex[]> vertices(new ScreenVertex[mesh.positions.size()]);
    project(mesh, Projection(camera, sample_rows, sample_columns), vertices.get());
    set_up(operation, mesh, camera, culling, vertices.get());
    vertices.reset();
    deal_out();
  }

  [[nodiscard]] std::size_t tile_rows() const { return tile_rows_; }
  [[nodiscard]] std::size_t tile_columns() const { return tile_columns_; }

  /// Frees the memory of draw(), which must not be called afterwards; positions stay.
  void free_triangles() {
    blocks_.clear();
    blocks_.shrink_to_fit();
    begin_ = {};
    triangles_.reset();
  }

  /// Faces left out since a corner is not finite (or beyond 1e100).
  [[nodiscard]] std::size_t non_finite_faces() const { return non_finite_faces_; }

  /// All positions of the mesh in view space; those that are not finite stay so.
  [[nodiscard]] const std::vector<geometry::Vector3>& positions_view() const { return positions_view_; }

  [[nodiscard]] bool is_empty(std::size_t tile_row, std::size_t tile_column) const {
    const std::size_t tile = tile_row * tile_columns_ + tile_column;
    return begin_[tile] == begin_[tile + 1];
  }

  /// Draws a tile, [rows, columns] samples at the picture's edge and tile_height · tile_width elsewhere.
  ///
  /// \param faces   of the tile's first sample, −1 everywhere; keeps it where the tile shows nothing
  /// \param stride  of faces
  void draw(std::size_t tile_row, std::size_t tile_column, std::int32_t* faces, std::size_t stride) const {
    if (is_empty(tile_row, tile_column)) return;
    alignas(64) std::array<float, tile_height * tile_width> depth;
    alignas(64) std::array<std::int32_t, tile_height * tile_width> own;
    const auto rows = block_range(tile_row, sample_rows_, tile_height);
    const auto columns = block_range(tile_column, sample_columns_, tile_width);
    const bool is_whole = (columns.end - columns.begin) % depth_group == 0;  // else kernels write beyond
    const Tile tile{static_cast<std::int32_t>(rows.begin),
                    static_cast<std::int32_t>(columns.begin),
                    static_cast<std::int32_t>(rows.end - rows.begin),
                    static_cast<std::int32_t>(columns.end - columns.begin),
                    is_whole ? faces : own.data(),
                    is_whole ? stride : tile_width,
                    depth.data()};
    std::fill_n(depth.data(), (rows.end - rows.begin) * tile_width, 0.0F);
    if (!is_whole) own.fill(-1);
    const std::size_t index = tile_row * tile_columns_ + tile_column;
    kernels_.draw_triangles(triangles_.get() + begin_[index], begin_[index + 1] - begin_[index], tile);
    for (std::size_t row = 0; !is_whole && row < rows.end - rows.begin; ++row)
      std::copy_n(own.data() + row * tile_width, columns.end - columns.begin, faces + row * stride);
  }

 private:
  /// Triangles of a run of faces, in face order, and the number of them in each tile.
  struct Block {
    std::unique_ptr<ScreenTriangle[]> triangles;
    std::unique_ptr<TileRange[]> tiles;  ///< of each triangle
    std::size_t size = 0;
    std::vector<std::uint32_t> counts;
    std::size_t non_finite_faces = 0;
  };

  void project(const geometry::Mesh& mesh, const Projection& projection, ScreenVertex* vertices) {
    constexpr std::size_t block = 2048;
    parallel_for_blocks(mesh.positions.size(), block, [&](std::size_t begin, std::size_t end) {
      kernels_.project(projection, mesh.positions.data() + begin, end - begin, positions_view_.data() + begin,
                       vertices + begin);
    });
  }

  void set_up(const char* operation, const geometry::Mesh& mesh, const geometry::Camera& camera,
              FaceCulling culling, const ScreenVertex* vertices) {
    const RayGrid rays(camera, sample_rows_, sample_columns_);
    const detail::CutSetup cut_setup(camera, sample_rows_, sample_columns_, culling);
    const std::size_t block = std::max<std::size_t>(2048, mesh.faces.size() / 64);
    blocks_.resize(block_count(mesh.faces.size(), block));
    parallel_for(blocks_.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, mesh.faces.size(), block);
      const std::uint32_t highest = kernels_.highest_index(mesh.faces[begin].data(), 3 * (end - begin));
      if (highest >= mesh.positions.size()) require_corners(operation, mesh);
      const std::unique_ptr<std::int32_t[]> listed(new std::int32_t[end - begin + 1]);
      const std::size_t count = kernels_.list_faces(mesh.faces.data(), static_cast<std::int32_t>(begin),
                                                    static_cast<std::int32_t>(end - begin), vertices,
                                                    static_cast<std::int32_t>(sample_columns_),
                                                    static_cast<std::int32_t>(sample_rows_), listed.get());
      set_up_block(mesh, rays, cut_setup, culling, vertices, listed.get(), count, blocks_[index]);
      count_tiles(blocks_[index]);
    });
    for (const Block& done : blocks_) non_finite_faces_ += done.non_finite_faces;
  }

  void set_up_block(const geometry::Mesh& mesh, const RayGrid& rays, const detail::CutSetup& cut_setup,
                    FaceCulling culling, const ScreenVertex* vertices, const std::int32_t* listed,
                    std::size_t count, Block& block) const {
    const auto is_cut = [](std::int32_t face) { return face < 0; };
    const auto cut_count = static_cast<std::size_t>(std::count_if(listed, listed + count, is_cut));
    const std::size_t most = count + cut_count * (detail::CutSetup::most_triangles - 1);
    block.triangles.reset(new ScreenTriangle[most]);
    block.tiles.reset(new TileRange[most]);
    const SetupOptions options{static_cast<std::int32_t>(sample_columns_),
                               static_cast<std::int32_t>(sample_rows_), culling == FaceCulling::back};
    for (std::size_t i = 0; i < count; ++i) {
      const auto run =
          static_cast<std::size_t>(std::find_if(listed + i, listed + count, is_cut) - (listed + i));
      block.size +=
          kernels_.set_up(rays, mesh.faces.data(), listed + i, run, vertices, positions_view_.data(), options,
                          block.triangles.get() + block.size, block.tiles.get() + block.size);
      i += run;
      if (i == count) break;
      const std::int32_t face = ~listed[i];
      std::array<geometry::Vector3, 3> corners;
      bool is_usable = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto corner = static_cast<std::size_t>(mesh.faces[static_cast<std::size_t>(face)][k]);
        corners[k] = positions_view_[corner];
        is_usable = is_usable && vertices[corner].outside != unusable;
      }
      if (is_usable) {
        const std::size_t made = cut_setup.add(face, corners, block.triangles.get() + block.size);
        for (std::size_t end = block.size + made; block.size < end; ++block.size)
          block.tiles[block.size] = tile_range(block.triangles[block.size]);
      } else {
        ++block.non_finite_faces;
      }
    }
  }

  void count_tiles(Block& block) const {
    block.counts.assign(tile_rows_ * tile_columns_, 0);
    for (std::size_t i = 0; i < block.size; ++i)
      for_each_tile(block.tiles[i], [&](std::size_t tile) { ++block.counts[tile]; });
  }

  [[nodiscard]] TileRange tile_range(const ScreenTriangle& triangle) const {
    const SampleRange rows = sample_range(triangle.y, sample_rows_);
    const SampleRange columns = sample_range(triangle.x, sample_columns_);
    constexpr std::int32_t high = tile_height, wide = tile_width;
    return {static_cast<std::uint16_t>(columns.first / wide), static_cast<std::uint16_t>(rows.first / high),
            static_cast<std::uint16_t>(columns.last / wide), static_cast<std::uint16_t>(rows.last / high)};
  }

  template <class Visit>
  void for_each_tile(const TileRange& range, Visit visit) const {
    for (std::size_t row = range.first_row; row <= range.last_row; ++row)
      for (std::size_t column = range.first_column; column <= range.last_column; ++column)
        visit(row * tile_columns_ + column);
  }

  /// Lists each tile's triangles in the order of their faces: a counting sort.
  void deal_out() {
    begin_.resize(tile_rows_ * tile_columns_ + 1);
    std::size_t total = 0;
    for (std::size_t tile = 0; tile + 1 < begin_.size(); ++tile) {
      begin_[tile] = total;
      for (Block& block : blocks_) total += block.counts[tile];
    }
    begin_.back() = total;
    triangles_.reset(new const ScreenTriangle*[total]);
    parallel_for(blocks_.size(), [&](std::size_t index) {
      std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
      for (std::size_t before = 0; before < index; ++before)
        for (std::size_t tile = 0; tile < next.size(); ++tile) next[tile] += blocks_[before].counts[tile];
      const Block& block = blocks_[index];
      for (std::size_t i = 0; i < block.size; ++i)
        for_each_tile(block.tiles[i],
                      [&](std::size_t tile) { triangles_[next[tile]++] = &block.triangles[i]; });
    });
    for (Block& block : blocks_) {  // has served its purpose
      block.tiles.reset();
      block.counts = {};
    }
  }

  const RasterKernels& kernels_;
  std::size_t sample_rows_;
  std::size_t sample_columns_;
  std::size_t tile_rows_;
  std::size_t tile_columns_;
  std::vector<geometry::Vector3> positions_view_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> begin_;  ///< of each tile's triangles, and their end
  std::unique_ptr<const ScreenTriangle*[]> triangles_;
  std::size_t non_finite_faces_ = 0;
};
}  // namespace tapestry::raster

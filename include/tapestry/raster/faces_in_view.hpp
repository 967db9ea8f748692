#pragma once
#include <span>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/detail/pixel_rays.hpp>
#include <tapestry/raster/detail/view_clip.hpp>

namespace tapestry::raster {
/// The part of a picture that a face may touch, in pixels, {column, row}, and its 1/z; empty when low > high.
struct FaceBox {
  std::array<double, 2> low{1, 1};
  std::array<double, 2> high{0, 0};
  double inverse_depth_min = std::numeric_limits<double>::infinity();
  double inverse_depth_max = 0;

  [[nodiscard]] bool is_empty() const { return !(low[0] <= high[0] && low[1] <= high[1]); }
};

namespace detail {
inline void add_point(FaceBox& box, const std::array<double, 2>& point, double inverse_depth) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    box.low[axis] = std::min(box.low[axis], point[axis]);
    box.high[axis] = std::max(box.high[axis], point[axis]);
  }
  box.inverse_depth_min = std::min(box.inverse_depth_min, inverse_depth * (1 - 1e-9));
  box.inverse_depth_max = std::max(box.inverse_depth_max, inverse_depth * (1 + 1e-9));
}
}  // namespace detail

/// The frame that boxes of faces are measured in.
struct PictureFrame {
  PixelRays rays;
  ViewClip clip;
  std::array<double, 2> size;  ///< columns, rows

  PictureFrame(const geometry::Camera& camera, std::size_t height, std::size_t width)
      : rays(camera, height, width),
        clip(camera, height, width),
        size{static_cast<double>(width), static_cast<double>(height)} {}

  /// The box of a face between near and far, cut to the picture; empty if it lies outside.
  /// \param corners  in view space, usable()
  [[nodiscard]] FaceBox box_of(const std::array<geometry::Vector3, 3>& corners) const {
    unsigned all = ~0U, any = 0;
    for (const geometry::Vector3& corner : corners) {
      const unsigned outside = clip.outside(corner);
      all &= outside;
      any |= outside;
    }
    if ((all & ViewClip::invisible) != 0) return {};
    FaceBox box{size, {0, 0}};
    if ((any & ViewClip::needs_cut) == 0) {
      for (const geometry::Vector3& corner : corners)
        detail::add_point(box, rays.picture_point(corner), 1 / corner[2]);
    } else {
      const ViewClip::Polygon polygon = clip.cut(corners);
      for (std::size_t i = 0; polygon.size >= 3 && i < polygon.size; ++i)
        detail::add_point(box, rays.picture_point(polygon.points[i]), 1 / polygon.points[i][2]);
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      box.low[axis] = std::max(box.low[axis], 0.0);
      box.high[axis] = std::min(box.high[axis], size[axis]);
    }
    return box;
  }
};

/// Side of a face: from its corner `corner` to the next one.
struct HalfEdge {
  std::int32_t face;
  std::int32_t corner;
};

/// The edges of a mesh, each with all faces that have it: one at a border, two inside, more where surfaces
/// meet or faces are repeated. They stay valid while the faces stay, even if positions move. Positions that
/// had the same coordinates when the edges were made count as one, so that a seam of duplicated vertices is
/// no border.
struct MeshEdges {
  std::vector<std::int32_t> welded;  ///< for each position the first one with its coordinates
  std::vector<HalfEdge> half_edges;  ///< edge by edge; in each edge by face
  std::vector<std::uint32_t> begin;  ///< first half-edge of each edge, and the end
  /// Orientation of an edge of two faces: 1 if they run along it in opposite ways, as on a surface with one
  /// side outwards, −1 if alike; times 2 at a seam, where the faces have positions of their own. 0 for other
  /// edges.
  std::vector<std::int8_t> way;
  std::size_t face_count = 0;
  /// Whether the mesh is one closed surface with one side outwards: each edge has two faces, which run along
  /// it in opposite ways, and all faces are connected.
  bool is_closed = false;

  [[nodiscard]] std::size_t size() const { return begin.size() - 1; }
  [[nodiscard]] std::span<const HalfEdge> of(std::size_t edge) const {
    return {half_edges.data() + begin[edge], begin[edge + 1] - begin[edge]};
  }
};

/// For each position the first one with its coordinates; those that are NaN stay alone. A hash table with
/// open addressing.
[[nodiscard]] std::vector<std::int32_t> welded_positions(const geometry::Mesh& mesh);

/// \pre every corner of every face exists, see require_corners()
[[nodiscard]] MeshEdges mesh_edges(const geometry::Mesh& mesh);

/// Quick facts about every face of a view: whether it is drawn, which way it turns, and where.
class FacesInView {
 public:
  /// {column, row} in pixels, rounded to nearest; empty when low > high.
  struct Box {
    std::array<float, 2> low{1, 1};
    std::array<float, 2> high{0, 0};
    [[nodiscard]] bool is_empty() const { return !(low[0] <= high[0] && low[1] <= high[1]); }
    [[nodiscard]] double area() const {  ///< unless empty
      return static_cast<double>(high[0] - low[0]) * static_cast<double>(high[1] - low[1]);
    }
  };

  /// The part of the picture that faces may touch, the number of these faces, and the sum of their boxes'
  /// areas.
  struct Extent {
    Box box;
    std::size_t count = 0;
    double area = 0;  ///< px²
  };

  /// \param mesh            must outlive this, as must positions_view
  /// \param positions_view  its positions in view space
  FacesInView(const geometry::Mesh& mesh, const std::vector<geometry::Vector3>& positions_view,
              const geometry::Camera& camera, std::size_t height, std::size_t width)
      : mesh_(mesh),
        positions_view_(positions_view),
        frame_(camera, height, width),
        places_(places_of_positions()),
        winding_(mesh.faces.size(), 0) {
    constexpr std::size_t block = 4096;
    std::vector<Extent> extents(block_count(winding_.size(), block));
    parallel_for(extents.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, winding_.size(), block);
      for (std::size_t face = begin; face < end; ++face) {
        const Box own = box(face);
        if (own.is_empty()) continue;
        winding_[face] = winding_of(face);
        add(extents[index], {own, 1, own.area()});
      }
    });
    for (const Extent& part : extents) add(extent_, part);
  }

  [[nodiscard]] const geometry::Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const std::vector<geometry::Vector3>& positions_view() const { return positions_view_; }
  [[nodiscard]] const PictureFrame& frame() const { return frame_; }
  [[nodiscard]] const Extent& extent() const { return extent_; }

  /// 1 or −1 for the two orientations of a face's corners in the picture, 0 for a face that is not drawn.
  [[nodiscard]] int winding(std::int32_t face) const { return winding_[static_cast<std::size_t>(face)]; }

  /// Marks the faces of a winding as not drawn.
  void leave_out(int winding) {
    for (std::int8_t& own : winding_) own = own == winding ? std::int8_t{0} : own;
  }

  /// Computed in each call, since most faces need it once.
  [[nodiscard]] Box box(std::size_t face) const {
    const auto place = [&](std::size_t k) -> const Place& {
      return places_[static_cast<std::size_t>(mesh_.faces[face][k])];
    };
    const Place &a = place(0), &b = place(1), &c = place(2);
    const unsigned any = a.outside | b.outside | c.outside;
    Box box;
    if ((any & unusable) != 0 || (a.outside & b.outside & c.outside & ViewClip::invisible) != 0) return box;
    if ((any & ViewClip::needs_cut) != 0) {
      const FaceBox cut = frame_.box_of(corners(face));
      for (std::size_t axis = 0; axis < 2; ++axis) {
        box.low[axis] = static_cast<float>(cut.low[axis]);
        box.high[axis] = static_cast<float>(cut.high[axis]);
      }
      return box;
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const float size = static_cast<float>(frame_.size[axis]);
      box.low[axis] = std::max(std::min({a.point[axis], b.point[axis], c.point[axis]}), 0.0F);
      box.high[axis] = std::min(std::max({a.point[axis], b.point[axis], c.point[axis]}), size);
    }
    return box;
  }

  /// In view space.
  [[nodiscard]] std::array<geometry::Vector3, 3> corners(std::size_t face) const {
    std::array<geometry::Vector3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = positions_view_[static_cast<std::size_t>(mesh_.faces[face][k])];
    return corners;
  }

 private:
  /// A position in the picture.
  struct Place {
    std::array<float, 2> point;
    unsigned outside;  // see ViewClip::outside(), or `unusable`
  };

  [[nodiscard]] std::vector<Place> places_of_positions() const {
    std::vector<Place> places(positions_view_.size());
    constexpr std::size_t block = 4096;
    parallel_for_blocks(places.size(), block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const geometry::Vector3& view = positions_view_[i];
        const std::array<double, 2> point = frame_.rays.picture_point(view);
        for (std::size_t axis = 0; axis < 2; ++axis)
          places[i].point[axis] = static_cast<float>(std::clamp(point[axis], -1e6, 1e6));
        places[i].outside = detail::usable(view) ? frame_.clip.outside(view) : unusable;
      }
    });
    return places;
  }

  /// The winding of a face; 0 for a face that is seen from its side, where 1/z is not finite.
  [[nodiscard]] std::int8_t winding_of(std::size_t face) const {
    const auto q = corners(face);
    const double volume = geometry::dot(q[0], geometry::cross(q[1], q[2]));
    if (!std::isfinite(1 / volume)) return 0;
    return volume > 0 ? 1 : -1;
  }

  static void add(Extent& sum, const Extent& part) {
    if (part.count == 0) return;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const float low = part.box.low[axis], high = part.box.high[axis];
      sum.box.low[axis] = sum.count == 0 ? low : std::min(sum.box.low[axis], low);
      sum.box.high[axis] = sum.count == 0 ? high : std::max(sum.box.high[axis], high);
    }
    sum.count += part.count;
    sum.area += part.area;
  }

  const geometry::Mesh& mesh_;
  const std::vector<geometry::Vector3>& positions_view_;
  PictureFrame frame_;
  std::vector<Place> places_;
  std::vector<std::int8_t> winding_;
  Extent extent_;
};
}  // namespace tapestry::raster

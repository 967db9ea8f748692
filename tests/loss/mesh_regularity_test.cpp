#include <tapestry/loss/mesh_regularity.hpp>

#include <tapestry/geometry/detail/rotation.hpp>
#include <tapestry/geometry/point_columns.hpp>
#include <tapestry/geometry/shapes.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;

namespace {
/// A sphere out of shape.
template <class T>
Array<T, 2> bumpy(const geometry::Mesh& mesh) {
  auto positions = geometry::position_array<T>(mesh);
  const auto bumps = test::random_array<T>({mesh.positions.size(), 3}, 3, -0.15, 0.15);
  for (std::size_t i = 0; i < positions.size(); ++i) positions.data()[i] += bumps.data()[i];
  return positions;
}
}  // namespace

TEST_CASE("regularity of two triangles, worked out by hand", "[loss][mesh_regularity]") {
  geometry::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, -2, 0}, {9, 9, 9}};  // the last is alone
  mesh.faces = {{0, 1, 2}, {0, 3, 1}};
  const auto topology = geometry::mesh_topology(mesh);
  auto at = geometry::position_array<double>(mesh);
  // Umbrellas: (2/3, 0, 0), (−2, 0, 0), (1, −2, 0), (1, 2, 0), none.
  CHECK(loss::laplacian(topology, at) == Approx((4.0 / 9 + 4 + 5 + 5) / 5));
  // Edges: 2, 2, 2 and twice √8.
  CHECK(loss::edge_length(topology, at) == Approx((3 * 4 + 2 * 8) / 5.0));
  CHECK(loss::edge_length(topology, at, 2) == Approx(2 * std::pow(std::sqrt(8.0) - 2, 2) / 5));
  CHECK(std::abs(loss::normal_consistency(topology, at)) <= 1e-15);
  at(3, 1) = 0, at(3, 2) = 2;  // a right angle
  CHECK(loss::normal_consistency(topology, at) == Approx(1));
  at(3, 1) = 2, at(3, 2) = 0;  // folded together
  CHECK(loss::normal_consistency(topology, at) == Approx(2));
}

TEST_CASE("regularity does not change as a mesh moves and turns, and grows with its square",
          "[loss][mesh_regularity]") {
  const auto mesh = geometry::icosphere(2);
  const auto topology = geometry::mesh_topology(mesh);
  const auto at = bumpy<double>(mesh);
  auto moved = at, doubled = at;
  const auto turn = geometry::exponential_map(geometry::Vector3{0.4, 1.2, -0.7});
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto position = geometry::multiply(turn, {at(i, 0), at(i, 1), at(i, 2)});
    for (std::size_t k = 0; k < 3; ++k) moved(i, k) = position[k] + 3, doubled(i, k) = 2 * at(i, k);
  }
  CHECK(loss::laplacian(topology, moved) == Approx(loss::laplacian(topology, at)).epsilon(1e-12));
  CHECK(loss::edge_length(topology, moved, 0.1) ==
        Approx(loss::edge_length(topology, at, 0.1)).epsilon(1e-12));
  CHECK(loss::normal_consistency(topology, moved) ==
        Approx(loss::normal_consistency(topology, at)).epsilon(1e-12));
  CHECK(loss::laplacian(topology, doubled) == Approx(4 * loss::laplacian(topology, at)).epsilon(1e-12));
  CHECK(loss::edge_length(topology, doubled) == Approx(4 * loss::edge_length(topology, at)).epsilon(1e-12));
  CHECK(loss::normal_consistency(topology, doubled) ==
        Approx(loss::normal_consistency(topology, at)).epsilon(1e-12));
}

TEST_CASE("a plane is flat whatever its winding, and even inside", "[loss][mesh_regularity]") {
  auto mesh = geometry::plane(4, 5);
  for (std::size_t face = 0; face < mesh.faces.size(); face += 3)
    std::swap(mesh.faces[face][0], mesh.faces[face][1]);
  CHECK(std::abs(loss::normal_consistency(geometry::mesh_topology(mesh),
                                          geometry::position_array<double>(mesh))) <= 1e-14);
}

TEMPLATE_TEST_CASE("derivatives of regularity on the tape agree with central differences",
                   "[loss][mesh_regularity][gradient]", float, double) {
  const auto mesh = geometry::icosphere(1);
  const auto topology = geometry::mesh_topology(mesh);
  const auto at = bumpy<TestType>(mesh);
  const auto check = [&](auto value) {
    test::ActiveTape<TestType> tape;
    const auto positions = tape.input(at);
    tape.reverse(value(positions) + TestType(2) * value(positions));
    const auto direction = test::random_direction<TestType>({mesh.positions.size(), 3}, 5);
    const auto thrice = [&](const Array<TestType, 2>& x) { return 3 * value(x); };
    CHECK(std::abs(test::dot(positions.adjoint(), direction) -
                   test::central_difference(thrice, at, direction)) <=
          4 * test::central_difference_tolerance(thrice(at)));  // third derivatives up to about 4
    CHECK(tape.record_count() == 3);
  };
  check([&](const auto& x) { return loss::laplacian(topology, x); });
  check([&](const auto& x) { return loss::edge_length(topology, x, 0.3); });
  check([&](const auto& x) { return loss::normal_consistency(topology, x); });
}

TEST_CASE("edges and faces without extent pull nowhere, and passive positions record nothing",
          "[loss][mesh_regularity]") {
  geometry::Mesh mesh;
  mesh.positions.resize(4, {1, 2, 3});
  mesh.faces = {{0, 1, 2}, {1, 0, 3}};
  const auto topology = geometry::mesh_topology(mesh);
  const auto at = geometry::position_array<double>(mesh);
  auto gradient = tapestry::zeros<double, 2>({4, 3});
  loss::edge_length_adjoint(topology, at, 1.0, 1.0, gradient);
  loss::normal_consistency_adjoint(topology, at, 1.0, gradient);
  CHECK((gradient == tapestry::zeros<double, 2>({4, 3})));
  CHECK(loss::normal_consistency(topology, at) == 0);
  CHECK(loss::laplacian(geometry::MeshTopology{}, tapestry::zeros<double, 2>({0, 3})) == 0);
  test::ActiveTape<double> tape;
  const ArrayVariable<double, 2> passive(at);
  CHECK(loss::laplacian(topology, passive).value() == 0);
  CHECK(tape.record_count() == 0);
  CHECK_THROWS_WITH(loss::laplacian(topology, tapestry::zeros<double, 2>({3, 3})),
                    "laplacian: positions is [3, 3], expected [4, 3]");
}

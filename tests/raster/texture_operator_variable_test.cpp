#include <tapestry/raster/texture_operator.hpp>

#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
template <class T>
using Pictures = std::vector<std::shared_ptr<const raster::CompactOperator<T>>>;

/// Views of one texture of different sizes.
template <class T>
Pictures<T> some_views(std::size_t count, const raster::TextureLayout& layout = test::atlas) {
  Pictures<T> pictures;
  for (std::size_t n = 0; n < count; ++n) {
    const auto mesh = test::random_triangles(30, n + 1, 0.9);
    pictures.push_back(std::make_shared<const raster::CompactOperator<T>>(raster::compacted(
        raster::texture_operator<T>({mesh, test::every_face(mesh), layout}, {}, 20 + n, 24, test::warm))));
  }
  return pictures;
}

template <class T>
Variable<T> weighted(const ArrayVariable<T, 3>& picture, std::uint64_t seed) {
  const auto& shape = picture.shape();
  return tapestry::sum(picture * ArrayVariable<T, 3>(random_array<T>({shape[0], shape[1], 3}, seed)));
}

template <class T>
Variable<T> weighted(const std::vector<ArrayVariable<T, 3>>& pictures) {
  Variable<T> sum = 0;
  for (std::size_t n = 0; n < pictures.size(); ++n) sum = sum + weighted(pictures[n], 10 + n);
  return sum;
}
}  // namespace

TEMPLATE_TEST_CASE("render on the tape pulls back to render_adjoint", "[raster][variable][gradient]", float,
                   double) {
  const auto views = some_views<TestType>(1);
  ActiveTape<TestType> tape;
  const auto texels = tape.input(random_array<TestType>({views[0]->texel_count, 3}, 2));
  const auto picture = raster::render(*views[0], texels);
  CHECK((picture.value() == raster::render(*views[0], texels.value())));
  tape.reverse(weighted(picture, 3));
  auto expected = tapestry::zeros<TestType, 2>(texels.shape());
  raster::render_adjoint(*views[0], random_array<TestType>({20, 24, 3}, 3), expected);
  CHECK((texels.adjoint() == expected));
}

TEST_CASE("several views on the tape are one record and agree with central differences",
          "[raster][variable][gradient]") {
  const auto views = some_views<double>(3);
  const auto texels = random_array<double>({views[0]->whole_count, 3}, 2);
  ActiveTape<double> tape;
  const auto input = tape.input(texels);
  const std::size_t before = tape.record_count();
  const auto pictures = raster::render(views, input);
  CHECK(tape.record_count() == before + 1);
  CHECK(pictures[2].shape() == Extents<3>{22, 24, 3});
  const auto square = [](const auto& all) { return weighted(all) * weighted(all); };
  tape.reverse(square(pictures));
  const auto value = [&](const Array<double, 2>& at) {
    return square(raster::render(views, ArrayVariable<double, 2>(at))).value();
  };
  const auto direction = test::random_direction<double>({views[0]->whole_count, 3}, 5);
  const double expected = test::central_difference(value, texels, direction);
  CHECK(test::dot(input.adjoint(), direction) == Approx(expected).epsilon(1e-6));
}

TEST_CASE("views that nothing depends on, passive textures and a second record change no sum",
          "[raster][variable]") {
  auto views = some_views<double>(2);
  const auto texels = random_array<double>({views[0]->whole_count, 3}, 2);
  ActiveTape<double> tape;
  CHECK(!raster::render(views, ArrayVariable<double, 2>(texels))[1].is_active());
  CHECK(!raster::render(*views[0], ArrayVariable<double, 2>(raster::own_texels(*views[0], texels)))
             .is_active());
  CHECK(tape.record_count() == 0);
  const auto gradient = [&](std::size_t times) {
    Tape<double> own;
    const auto own_scope = own.activate();
    const auto input = own.input(texels);
    Variable<double> loss = 0;
    for (std::size_t i = 0; i < times; ++i) loss = loss + weighted(raster::render(views, input)[1], 4);
    own.reverse(loss);
    return Array<double, 2>(input.adjoint());
  };
  const auto once = gradient(1), twice = gradient(2);
  auto of_view = tapestry::zeros<double, 2>({views[1]->texel_count, 3}),
       expected = tapestry::zeros<double, 2>(texels.shape());
  raster::render_adjoint(*views[1], random_array<double>({21, 24, 3}, 4), of_view);
  raster::add_own_texels(*views[1], of_view, 1.0, expected);
  CHECK((once == expected));
  for (std::size_t i = 0; i < once.size(); ++i) CHECK(twice.data()[i] == 2 * once.data()[i]);
}

TEST_CASE("the tape keeps views alive and sums them to the same bits on any number of threads",
          "[raster][variable]") {
  const raster::TextureLayout large{raster::TextureKind::atlas, 300, 300, 1, 0};
  for (const auto& layout : {test::atlas, large})
    same_by_threads({1, 2, 3}, [&] {
      ActiveTape<float> tape;
      auto views = some_views<float>(4, layout);
      const auto input = tape.input(random_array<float>({views[0]->whole_count, 3}, 2));
      const auto loss = weighted(raster::render(views, input));
      views.clear();
      tape.reverse(loss);
      return input.adjoint();
    });
}

TEST_CASE("render on the tape refuses a texture of another size", "[raster][variable][bad_input]") {
  const auto views = some_views<double>(2);
  CHECK_THROWS_WITH(raster::render(views, ArrayVariable<double, 2>(tapestry::zeros<double, 2>({3, 3}))),
                    "own_texels: texels is [3, 3], expected [128, 3]");
}

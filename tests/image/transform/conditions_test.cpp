#include <tapestry/image/transform/chain.hpp>

#include "../../support/catch.hpp"
#include "../../support/random_array.hpp"

using namespace tapestry;

namespace {
template <class Kind>
const Kind* find(const image::TransformationChain& chain) {
  for (const auto& transformation : chain)
    if (const Kind* const found = std::get_if<Kind>(&transformation)) return found;
  return nullptr;
}
}  // namespace

TEST_CASE("without conditions nothing happens to a picture", "[image][transform][conditions]") {
  CHECK(image::draw_chain({}, Random(1), true).empty());
  const auto texels = test::random_array<double>({5, 3}, 1);
  const auto printed = image::transformed(texels, image::draw_print({}, Random(1)));
  CHECK((printed == texels));
}

TEST_CASE("conditions are drawn within their ranges, the same for a seed", "[image][transform][conditions]") {
  const image::Conditions& all = image::physical_conditions;
  bool has_shadow = false, has_none = false;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto chain = image::draw_chain(all, Random(seed), false),
               again = image::draw_chain(all, Random(seed), false);
    REQUIRE(chain.size() == 6);
    const auto* blur = find<image::Blur>(chain);
    CHECK((blur->across_px >= 0 && blur->across_px <= all.blur_px));
    CHECK(blur->across_px == find<image::Blur>(again)->across_px);
    const auto* light = find<image::LightChange>(chain);
    CHECK((light->gain[1] >= 0.5 && light->gain[1] <= 2));
    CHECK((light->shadow >= 0 && light->shadow <= 0.5));
    (light->shadow > 0 ? has_shadow : has_none) = true;
    const auto* jpeg = find<image::JpegCompression>(chain);
    CHECK((jpeg->quality >= 50 && jpeg->quality <= 95));
    CHECK_FALSE(jpeg->is_rounding_smooth);
    const auto* noise = find<image::SensorNoise>(chain);
    const double at_mid_grey = std::sqrt(noise->shot * 0.5 + noise->read * noise->read);
    CHECK((at_mid_grey >= 0 && at_mid_grey <= all.noise));
    CHECK(noise->seed == find<image::SensorNoise>(again)->seed);
  }
  CHECK((has_shadow && has_none));
}

TEST_CASE("what one range is does not change what others draw", "[image][transform][conditions]") {
  image::Conditions steady = image::physical_conditions;
  steady.turn_degrees = steady.roll_degrees = steady.zoom = 0;
  steady.exposure_stops = steady.colour_cast = steady.shadow = 0;
  const auto some = image::draw_chain(steady, Random(9), true);
  const auto all = image::draw_chain(image::physical_conditions, Random(9), true);
  CHECK(find<image::Warp>(some) == nullptr);
  CHECK(find<image::LightChange>(some) == nullptr);
  CHECK(find<image::Blur>(some)->down_px == find<image::Blur>(all)->down_px);
  CHECK(find<image::JpegCompression>(some)->quality == find<image::JpegCompression>(all)->quality);
  CHECK(find<image::JpegCompression>(some)->is_rounding_smooth);
}

TEST_CASE("a print keeps colours within its black and its white", "[image][transform][conditions]") {
  image::Conditions range_only;
  range_only.printed_range = 0.2;
  const auto print = image::draw_print(range_only, Random(3));
  const Array<double, 2> ends = {{0, 0, 0}, {1, 1, 1}};
  const auto printed = image::transformed(ends, print);
  CHECK((printed(0, 0) > 0 && printed(0, 0) < 0.2));
  CHECK((printed(1, 0) < 1 && printed(1, 0) > 0.8));
  CHECK(printed(0, 0) == printed(0, 2));
}

TEST_CASE("conditions by their names", "[image][transform][conditions][bad_input]") {
  CHECK(image::conditions_by_names({}) == image::Conditions{});
  CHECK(image::conditions_by_names({"physical"}) == image::physical_conditions);
  CHECK(image::conditions_by_names({"jpeg", "camera", "light", "blur", "noise", "contrast", "print"}) ==
        image::physical_conditions);
  image::Conditions blur_and_noise;
  blur_and_noise.blur_px = image::physical_conditions.blur_px;
  blur_and_noise.noise = image::physical_conditions.noise;
  CHECK(image::conditions_by_names({"noise", "blur"}) == blur_and_noise);
  CHECK_THROWS_WITH(image::conditions_by_names({"blur", "fog"}), contains("'fog' is none of camera"));
}

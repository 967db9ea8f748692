#include <tapestry/evaluate/survey.hpp>

#include <tapestry/camouflage/own_colours.hpp>

#include <stdexcept>

#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

namespace camouflage = tapestry::camouflage;
namespace evaluate = tapestry::evaluate;
namespace test = tapestry::test;

namespace {
struct Fixture {
  tapestry::raster::PaintedMesh car = test::tiny_car();
  tapestry::detect::Network<float> network = test::tiny_network<float>();
  camouflage::ViewStore<float> store = test::tiny_store<float>(car, 3);
  std::vector<std::size_t> views{0, 2};
  evaluate::Meter<float> meter{network, 1, {0.25, 0.45, {0.01}}};
  evaluate::SurveyedTextures<float> textures{
      camouflage::own_colours<float>(car),
      {},
      evaluate::make_controls<float>(car.layout.texel_count(car.mesh), 3)};
};
using Measured = evaluate::MeasuredPicture<float>;
}  // namespace

TEST_CASE("controls are noise that follows from the seed, and five solid colours", "[evaluate][controls]") {
  const auto controls = evaluate::make_controls<float>(5, 7);
  REQUIRE(controls.size() == 6);
  CHECK(controls[0].colours == evaluate::make_controls<float>(5, 7)[0].colours);
  CHECK(controls[0].colours != evaluate::make_controls<float>(5, 8)[0].colours);
  CHECK(controls[3].name == "red");
  for (std::size_t texel = 0; texel < 5; ++texel) {
    CHECK(controls[3].colours(texel, 0) == 0.75F);
    CHECK(controls[3].colours(texel, 2) == 0.08F);
  }
}

TEST_CASE("a survey shows each texture in each view, and the photo as it is", "[evaluate][survey]") {
  Fixture fixture;
  fixture.textures.adversarial = fixture.textures.controls.front().colours;
  std::vector<std::string> names;
  const auto survey = evaluate::survey(
      fixture.meter, fixture.store, fixture.views, fixture.textures, [&](const Measured& measured) {
        names.push_back(measured.texture + " " + measured.view.name);
        if (measured.texture == "photo") CHECK(measured.picture == measured.view.background);
        if (measured.texture == "clean")
          CHECK(measured.picture == camouflage::picture_of(measured.view, fixture.textures.clean));
        CHECK(measured.result.found == fixture.meter.examine(measured.picture, measured.view).found);
      });
  CHECK(names.size() == fixture.textures.pictures_a_view() * fixture.views.size());
  CHECK(std::vector(names.begin(), names.begin() + 5) ==
        std::vector<std::string>{"photo frame0", "photo frame2", "clean frame0", "clean frame2",
                                 "adversarial frame0"});
  CHECK(names.back() == "blue frame2");
  REQUIRE(survey.adversarial);
  CHECK(survey.photo.rate.views == 2);
  CHECK(survey.photo.sweep.size() == 1);
  REQUIRE(survey.controls.size() == 6);
  CHECK(survey.controls[0].found == survey.adversarial->found);  // the same colours
  CHECK(survey.asr.views == survey.clean.rate.detected);
}

TEST_CASE("a survey without a camouflage has no success to tell", "[evaluate][survey]") {
  Fixture fixture;
  fixture.textures.controls.clear();
  std::size_t pictures = 0;
  const auto survey = evaluate::survey(fixture.meter, fixture.store, fixture.views, fixture.textures,
                                       [&](const Measured&) { ++pictures; });
  CHECK(pictures == 4);
  CHECK(!survey.adversarial);
  CHECK(survey.asr.views == 0);
}

TEST_CASE("a survey's visitor can end it", "[evaluate][survey]") {
  Fixture fixture;
  const auto give_up = [](const Measured&) { throw std::runtime_error("enough"); };
  CHECK_THROWS_WITH(evaluate::survey(fixture.meter, fixture.store, fixture.views, fixture.textures, give_up),
                    "enough");
}

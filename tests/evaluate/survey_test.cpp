#include <tapestry/evaluate/measurement.hpp>

#include "../support/charts.hpp"
#include "../support/random_array.hpp"
#include "../support/threads.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
struct Fixture {
  raster::PaintedMesh car = test::tiny_car();
  detect::Detector<float> network = test::tiny_detector<float>();
  camouflage::ViewStore<float> store = test::tiny_store<float>(car, 3);
  std::vector<std::size_t> views{0, 2};
  evaluate::Meter meter{network, 1, {0.25, 0.45, {0.01}}};
  evaluate::SurveyedTextures textures{camouflage::without_paint(camouflage::own_colours<float>(car)),
                                      {},
                                      evaluate::plain_controls(car.layout.texel_count(car.mesh), 3)};
};
using Measured = evaluate::MeasuredPicture;
}  // namespace

TEST_CASE("plain controls are noise that follows from the seed, and six solid colours",
          "[evaluate][controls]") {
  const auto controls = evaluate::plain_controls(5, 7);
  REQUIRE(controls.size() == 7);
  CHECK(controls[0].paint == evaluate::plain_controls(5, 7)[0].paint);
  CHECK(controls[0].paint.painted.empty());
  CHECK((controls[0].paint.colours != evaluate::plain_controls(5, 8)[0].paint.colours));
  CHECK(controls[4].name == "red");
  for (std::size_t texel = 0; texel < 5; ++texel) {
    CHECK(controls[4].paint.colours(texel, 0) == 0.75F);
    CHECK(controls[4].paint.colours(texel, 2) == 0.08F);
  }
}

TEST_CASE("the controls of a camouflage are matched noise and shuffled patches of it, then plain ones",
          "[evaluate][controls][repeated]") {
  const auto car = test::tiny_car(12, GENERATE(raster::TextureKind::atlas, raster::TextureKind::cube));
  const std::size_t texels = car.layout.texel_count(car.mesh);
  const auto colours = test::random_array<float>({texels, 3}, 9);
  const camouflage::Paint<float> paint{colours};
  const auto controls = evaluate::make_controls(car, paint, 3);
  std::vector<std::string> names;
  for (const auto& control : controls) {
    names.push_back(control.name);
    CHECK(control.paint.colours.shape(0) == texels);
  }
  CHECK(names == std::vector<std::string>{"matched noise", "shuffled", "random", "white", "grey", "black",
                                          "red", "green", "blue"});
  const auto again = evaluate::make_controls(car, paint, 3);
  const auto other = evaluate::make_controls(car, paint, 4);
  for (const std::size_t i : {0U, 1U, 2U}) {
    CHECK(controls[i].paint == again[i].paint);
    CHECK((controls[i].paint.colours != other[i].paint.colours));
  }
  auto seen = car;  // from around it, all but its bottom
  const auto is_seen = evaluate::faces_seen_around(car.mesh);
  CHECK(std::ranges::count(is_seen, 1) == 10);
  for (std::size_t face = 0; face < is_seen.size(); ++face) seen.painted[face] &= is_seen[face];
  const auto charts = raster::texture_charts(seen);
  const auto whole = evaluate::joined_chart(charts, car.layout);
  for (std::size_t c = 0; c < 3;
       ++c) {  // other places, the same values: of the whole car, and chart by chart
    CHECK(test::sorted_values(controls[0].paint.colours, whole, c) == test::sorted_values(colours, whole, c));
    for (const auto& chart : charts)
      CHECK(test::sorted_values(controls[1].paint.colours, chart, c) ==
            test::sorted_values(colours, chart, c));
  }
  CHECK((controls[0].paint.colours != colours));
  CHECK((controls[1].paint.colours != colours));
  CHECK(controls[0].share_in_place < 0.03);
  CHECK_THROWS_AS(evaluate::matched_controls(car, {test::random_array<float>({texels - 1, 3}, 9)}, 3),
                  ShapeError);
  const auto drawn = evaluate::matched_controls(car, paint, 3, 3);  // three draws, and the patches
  REQUIRE(drawn.size() == 4);
  CHECK(drawn[0].paint == controls[0].paint);
  CHECK(drawn[3].paint == controls[1].paint);
  for (const std::size_t i : {1U, 2U}) {
    CHECK(drawn[i].name == "matched noise");
    CHECK((drawn[i].paint.colours != drawn[i - 1].paint.colours));
    CHECK(test::sorted_values(drawn[i].paint.colours, whole, 0) == test::sorted_values(colours, whole, 0));
  }
}

TEST_CASE("charts joined keep their places in an atlas, and lie below each other elsewhere",
          "[evaluate][controls]") {
  const raster::TextureLayout atlas{raster::TextureKind::atlas, 4, 6};
  const std::vector<tapestry::raster::TextureChart> charts{{1, 2, {{0, 0, 8}, {0, 1, 9}}},
                                                           {1, 1, {{0, 0, 3}}}};
  const auto joined = evaluate::joined_chart(charts, atlas);
  CHECK(joined.height == 4);
  CHECK(joined.width == 6);
  REQUIRE(joined.texels.size() == 3);
  CHECK(joined.texels[0].texel == 3);  // row by row
  CHECK((joined.texels[0].row == 0 && joined.texels[0].column == 3));
  CHECK((joined.texels[1].row == 1 && joined.texels[1].column == 2));
  const auto stacked = evaluate::joined_chart(charts, {raster::TextureKind::vertex});
  CHECK(stacked.height == 2);
  CHECK(stacked.width == 2);
  CHECK((stacked.texels[2].row == 1 && stacked.texels[2].column == 0 && stacked.texels[2].texel == 3));
}

TEST_CASE("noise at eight rows has next to nothing of the paint at its place", "[evaluate][controls]") {
  // Within charts of a coarse atlas values have few places to go: a third and more stayed.
  const auto car = test::tiny_car(8);
  const camouflage::Paint<float> paint{test::random_array<float>({car.layout.texel_count(car.mesh), 3}, 9)};
  const auto controls = evaluate::matched_controls(car, paint, 3, 20);
  double mean = 0;
  for (std::size_t draw = 0; draw < 20; ++draw) mean += controls[draw].share_in_place / 20;
  CHECK(mean <= 0.03);  // chance: one in each of some hundred values
  CHECK(evaluate::noise_in_place(controls).value() == Approx(mean));
  CHECK_FALSE(evaluate::noise_in_place(evaluate::plain_controls(3, 1)));
}

TEST_CASE("controls of a camouflage of parts cover these parts, patches each piece for itself",
          "[evaluate][controls]") {
  const auto car = test::tiny_car(12);
  camouflage::Paint<float> paint{test::random_array<float>({car.layout.texel_count(car.mesh), 3}, 9)};
  const auto all = raster::texture_charts(car);
  // Paints two corners of the first chart's box, which do not touch, and nothing of the others.
  paint.painted.assign(paint.colours.shape(0), 0);
  const std::size_t height = all[0].height, width = all[0].width;
  REQUIRE(std::min(height, width) >= 4);
  for (const auto& texel : all[0].texels)
    paint.painted[texel.texel] = (texel.row < height / 2 && texel.column < width / 2 - 1) ||
                                         (texel.row >= height / 2 && texel.column > width / 2)
                                     ? 1
                                     : 0;
  const auto pieces = raster::painted_charts(all, paint.painted);
  REQUIRE(pieces.size() == 2);
  auto unsound = paint;
  unsound.painted.push_back(1);
  CHECK_THROWS_AS(evaluate::matched_controls(car, unsound, 3), ShapeError);
  for (const auto& control : evaluate::matched_controls(car, paint, 3)) {
    const auto& colours = control.paint.colours;
    CHECK(control.paint.painted == paint.painted);
    CHECK((colours != paint.colours));
    for (std::size_t texel = 0; texel < colours.shape(0); ++texel)
      if (paint.painted[texel] == 0)
        for (std::size_t c = 0; c < 3; ++c) REQUIRE(colours(texel, c) == paint.colours(texel, c));
    auto charts = pieces;  // patches stay in their piece, noise in all pieces
    if (control.name == evaluate::matched_noise_name) charts = {evaluate::joined_chart(pieces, car.layout)};
    for (const auto& chart : charts)
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(test::sorted_values(colours, chart, c) == test::sorted_values(paint.colours, chart, c));
  }
}

TEST_CASE("a survey shows each texture in each view, and the photo as it is", "[evaluate][survey]") {
  Fixture fixture;
  fixture.textures.adversarial = fixture.textures.controls.front().paint;
  std::vector<std::string> names;
  const auto survey = evaluate::survey(
      fixture.meter, fixture.store, fixture.views, fixture.textures, [&](const Measured& measured) {
        names.push_back(measured.texture + " " + measured.view.name);
        if (measured.texture == "photo") CHECK(measured.picture == measured.view.background);
        if (measured.texture == "clean")
          CHECK(measured.picture == camouflage::picture_of(measured.view, fixture.textures.clean.colours));
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
  REQUIRE(survey.controls.size() == 7);
  CHECK(survey.controls[0].found == survey.adversarial->found);  // the same colours
  CHECK(survey.asr.views == survey.clean.rate.detected);
}

TEST_CASE("a camouflage that moves the shape and its controls are measured in it, photo and clean are not",
          "[evaluate][survey]") {
  Fixture fixture;
  const auto moved = [&](float by) {
    auto offsets = tapestry::zeros<float, 2>({fixture.car.mesh.positions.size(), 3});
    for (std::size_t i = 2; i < offsets.size(); i += 3) offsets.data()[i] = by;
    return camouflage::reshaped(fixture.car, offsets);
  };
  const auto car = moved(0.02F), other_car = moved(-0.03F);
  auto reshaped = test::tiny_store<float>(car, 3), other = test::tiny_store<float>(other_car, 3);
  const auto control = fixture.textures.controls.front().paint;
  fixture.textures.adversarial = control;
  fixture.textures.controls = {{"random", control}, {evaluate::other_run_name, control}};
  fixture.textures.reshaped = &reshaped;
  fixture.textures.reshaped_by_other = &other;
  std::size_t pictures = 0;
  (void)evaluate::survey(fixture.meter, fixture.store, {1}, fixture.textures, [&](const Measured& measured) {
    auto& store = measured.texture == "clean" || measured.texture == "photo" ? fixture.store
                  : measured.texture == evaluate::other_run_name             ? other
                                                                             : reshaped;
    const auto view = store.view(1);
    CHECK(measured.target.cy == view->target.cy);
    if (measured.texture != "photo")
      CHECK((measured.picture ==
             camouflage::picture_of(
                 *view, (measured.texture == "clean" ? fixture.textures.clean : control).colours)));
    ++pictures;
  });
  CHECK(pictures == 5);
  CHECK(reshaped.view(1)->target.cy < fixture.store.view(1)->target.cy);
  CHECK(other.view(1)->target.cy > fixture.store.view(1)->target.cy);
}

TEST_CASE("a survey tells the best confidence of each view, and its mean", "[evaluate][survey]") {
  Fixture fixture;
  const auto survey =
      evaluate::survey(fixture.meter, fixture.store, fixture.views, fixture.textures, [](const Measured&) {});
  double sum = 0;
  REQUIRE(survey.clean.best_confidence.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto view = fixture.store.view(fixture.views[i]);
    const auto result =
        fixture.meter.examine(camouflage::picture_of(*view, fixture.textures.clean.colours), *view);
    CHECK(survey.clean.best_confidence[i] == result.best_confidence);
    sum += result.best_confidence;
  }
  CHECK(survey.clean.mean_best_confidence == sum / 2);
  CHECK(!survey.effect);
}

TEST_CASE("the effect of a camouflage is what its matched noise leaves over", "[evaluate][survey]") {
  Fixture fixture;
  fixture.views = {0, 1, 2};
  const camouflage::Paint<float> paint{
      test::random_array<float>({fixture.textures.clean.colours.shape(0), 3}, 2)};
  fixture.textures.controls = evaluate::make_controls(fixture.car, paint, 3);
  const auto measure = [&] {
    return evaluate::survey(fixture.meter, fixture.store, fixture.views, fixture.textures,
                            [](const Measured&) {});
  };
  CHECK(!measure().effect);  // of nothing
  fixture.textures.adversarial = paint;
  const auto survey = measure();
  REQUIRE(survey.effect);
  CHECK(survey.effect->control == "matched noise");
  const auto& noise = survey.controls.front();
  CHECK(survey.effect->best_confidence.pairs == 3);
  CHECK(survey.effect->best_confidence.mean ==
        Approx(noise.mean_best_confidence - survey.adversarial->mean_best_confidence).margin(1e-15));
  CHECK(survey.effect->p_at_50.mean ==
        Approx(noise.rate.p_at_50 - survey.adversarial->rate.p_at_50).margin(1e-15));
  CHECK(survey.effect->best_confidence.interval ==
        evaluate::paired_bootstrap(noise.best_confidence, survey.adversarial->best_confidence).interval);
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

TEST_CASE("views are photographed anew for each draw, in the same way for every texture",
          "[evaluate][conditions]") {
  Fixture fixture;
  fixture.textures.controls.resize(1);
  fixture.textures.controls[0].paint.colours = fixture.textures.clean.colours;
  fixture.textures.adversarial = fixture.textures.controls[0].paint;
  evaluate::Photography photography{image::physical_conditions, 3, 8};
  std::vector<tapestry::Array<float, 3>> pictures;
  const auto survey = [&] {
    pictures.clear();
    return evaluate::survey(
        fixture.meter, fixture.store, fixture.views, fixture.textures,
        [&](const Measured& measured) { pictures.push_back(measured.picture); }, photography);
  };
  const auto first = survey();
  REQUIRE(pictures.size() == 4 * 2 * 3);
  CHECK(first.clean.draws == 3);
  CHECK(first.clean.rate.views == 6);
  CHECK(first.clean.rate.interval == evaluate::wilson_interval(first.clean.rate.detected, 6, 3));
  CHECK(first.adversarial->best_confidence == first.controls[0].best_confidence);
  CHECK((pictures[12] == pictures[18]));
  CHECK((pictures[12] != pictures[13]));
  CHECK((pictures[6] != pictures[12]));  // the clean car is not printed
  for (std::size_t i = 0; i < 6; ++i)    // texels that all views share equal each picture's alone
    CHECK((pictures[12 + i] == evaluate::photograph_of(*fixture.store.view(fixture.views[i / 3]),
                                                       fixture.views[i / 3], &*fixture.textures.adversarial,
                                                       photography, i % 3)
                                   .picture));
  const auto again = survey();
  CHECK(again.photo.best_confidence == first.photo.best_confidence);
  photography.conditions.printed_range = photography.conditions.printed_error = 0;
  const auto unprinted = survey();
  CHECK(unprinted.clean.best_confidence == first.clean.best_confidence);
  CHECK(unprinted.clean.best_confidence == unprinted.controls[0].best_confidence);
  photography.seed = 9;
  CHECK(survey().photo.best_confidence != first.photo.best_confidence);
}

TEST_CASE("a survey is the same on any number of threads, bit for bit and in order", "[evaluate][survey]") {
  Fixture fixture;
  auto store = test::tiny_store<float>(fixture.car, 7);
  fixture.views = {6, 0, 1, 3, 5};
  fixture.textures.controls.resize(2);
  const evaluate::Photography photography{image::physical_conditions, 3, 8};
  std::vector<std::vector<std::string>> seen;
  std::vector<std::vector<double>> confidences;
  std::vector<std::vector<tapestry::Array<float, 3>>> pictures;
  for (const int threads : {1, 2, 4, 2}) {
    const test::Threads cap(threads);
    seen.emplace_back();
    pictures.emplace_back();
    const auto survey = evaluate::survey(
        fixture.meter, store, fixture.views, fixture.textures,
        [&](const Measured& measured) {
          seen.back().push_back(measured.texture + " " + measured.view.name);
          pictures.back().push_back(measured.picture);
        },
        photography);
    confidences.push_back(survey.controls[1].best_confidence);
    confidences.back().insert(confidences.back().end(), survey.photo.best_confidence.begin(),
                              survey.photo.best_confidence.end());
  }
  REQUIRE(seen[0].size() == 4 * 5 * 3);
  CHECK(seen[0][3] == "photo frame0");
  for (const std::size_t run : {1U, 2U, 3U}) {
    CHECK(seen[run] == seen[0]);
    CHECK(confidences[run] == confidences[0]);
    CHECK((pictures[run] == pictures[0]));
  }
}

TEST_CASE("an effect counts a view once, however often it was photographed", "[evaluate][conditions]") {
  evaluate::Measurement control{"matched noise", 2, {true, false, true, true}, {0.8, 0.4, 0.9, 0.7}};
  evaluate::Measurement adversarial{"adversarial", 2, {false, false, true, false}, {0.2, 0.4, 0.5, 0.3}};
  const auto effect = evaluate::effect_beyond(control, adversarial);
  CHECK(effect.best_confidence.pairs == 2);
  CHECK(effect.best_confidence.mean == Approx(0.35));
  CHECK(effect.p_at_50.mean == Approx(0.5));
}

TEST_CASE("a view is prepared once for all its photographs, on any number of threads", "[evaluate][survey]") {
  const test::Threads cap(GENERATE(1, 2, 8));
  Fixture fixture;
  std::atomic<int> loads{0};
  auto settings = fixture.store.settings();
  settings.keep_bytes = 0;
  auto store = test::tiny_store<float>(fixture.car, 5, settings, [&](std::size_t i) {
    ++loads;
    return test::tiny_frame(i);
  });
  const evaluate::Photography photography{image::conditions_by_names({"noise"}), 20, 3};
  const auto measured = evaluate::measure(
      "clean", fixture.meter, store, {0, 1, 2, 3, 4}, &fixture.textures.clean, [](const Measured&) {},
      photography);
  CHECK(measured.found.size() == 100);
  CHECK(loads == 5);
}

TEST_CASE(
    "pictures before a view that cannot be read are measured, and its error is told, on any number of "
    "threads",
    "[evaluate][survey][bad_input]") {
  const test::Threads cap(GENERATE(1, 2, 8));
  Fixture fixture;
  auto store = test::tiny_store<float>(fixture.car, 5, fixture.store.settings(), [](std::size_t i) {
    if (i >= 3) throw std::runtime_error("frame " + std::to_string(i) + " cannot be read");
    return test::tiny_frame(i);
  });
  std::size_t seen = 0;
  const camouflage::Paint<float>* const untouched = nullptr;
  CHECK_THROWS_WITH(evaluate::measure("photo", fixture.meter, store, {0, 1, 2, 3, 4}, untouched,
                                      [&](const Measured&) { ++seen; }),
                    "frame 3 cannot be read");
  CHECK(seen == 3);
}

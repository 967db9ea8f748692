#include <barrier>
#include <tapestry/camouflage/run_state.hpp>
#include <tapestry/raster/used_texels.hpp>

#include "../support/active_tape.hpp"
#include "../support/random_array.hpp"
#include "../support/refusal.hpp"
#include "../support/relative_distance.hpp"
#include "../support/temporary_folder.hpp"
#include "../support/threads.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
struct Fixture {
  raster::PaintedMesh car = test::tiny_car();
  detect::Detector<float> network = test::tiny_detector<float>();
  camouflage::ViewStore<float> store = test::tiny_store<float>(car, 4);
  camouflage::Objective<float> objective{network, {}};
  Array<float, 2> start = tapestry::zeros<float, 2>({car.layout.texel_count(car.mesh), 3});

  double worst_share = 1;
  std::size_t batch = 3;

  image::Conditions conditions{};

  camouflage::Training<float> training(std::size_t epochs, std::vector<std::size_t> usable = {0, 1, 2, 3}) {
    camouflage::TrainingOptions options;
    options.conditions = conditions;
    options.epochs = epochs;
    options.batch = batch;
    options.worst_share = worst_share;
    return {objective, store, std::move(usable), start, options};
  }
};
}  // namespace

TEST_CASE("training lowers the loss", "[camouflage][training]") {
  Fixture fixture;
  auto training = fixture.training(20);
  while (!training.finished()) training.step();
  REQUIRE(training.history().size() == 40);
  CHECK(training.history().back().total < training.history().front().total);
}

TEST_CASE("an interrupted training goes on to the same bits", "[camouflage][training]") {  // F13
  Fixture fixture;
  fixture.worst_share = GENERATE(1.0, 0.5);
  auto whole = fixture.training(4);
  while (!whole.finished()) whole.step();

  auto first = fixture.training(4);
  for (int i = 0; i < 3; ++i) first.step();
  const test::TemporaryFolder folder;
  camouflage::write_checkpoint(folder.path("checkpoint.npz"), first.state(), "settings");
  auto checkpoint = camouflage::read_checkpoint<float>(folder.path("checkpoint.npz"));
  CHECK(checkpoint.settings == "settings");
  auto second = fixture.training(4);
  second.restore(std::move(checkpoint.state));
  while (!second.finished()) second.step();
  CHECK(second.parameter() == whole.parameter());
  CHECK(second.history().size() == whole.history().size());
}

TEST_CASE("a checkpoint that no training wrote is refused by its name", "[camouflage][training][bad_input]") {
  Fixture fixture;
  auto training = fixture.training(4);
  for (int i = 0; i < 2; ++i) training.step();
  const test::TemporaryFolder folder;
  const auto refused = [&](ErrorKind kind, const char* text, auto change) {
    auto state = training.state();
    change(state);
    camouflage::write_checkpoint(folder.path("checkpoint.npz"), state, "settings");
    test::check_refused(kind, std::string("checkpoint.npz: ") + text,
                        [&] { (void)camouflage::read_checkpoint<float>(folder.path("checkpoint.npz")); });
  };
  using State = camouflage::TrainingState<float>;
  const auto malformed = ErrorKind::malformed;
  const auto mismatch = ErrorKind::mismatch;
  refused(malformed, "parameter holds", [](State& s) { s.parameter.data()[4] = std::nanf(""); });
  refused(malformed, "adam_first_moment holds",
          [](State& s) { s.adam.first_moment[1] = std::numeric_limits<float>::infinity(); });
  refused(malformed, "adam_second_moment holds", [](State& s) { s.adam.second_moment[1] = -1; });
  refused(mismatch, "adam_first_moment does not fit", [](State& s) { s.adam.first_moment.resize(5); });
  refused(mismatch, "adam_second_moment does not fit", [](State& s) { s.adam.second_moment.resize(5); });
  refused(mismatch, "adam_step does not fit", [](State& s) { s.adam.step = 0; });
  refused(mismatch, "history does not fit", [](State& s) { s.step = s.adam.step = 1'000'000; });
}

TEST_CASE("training gives the same bits for one and two threads", "[camouflage][training]") {  // T16
  Fixture fixture;
  fixture.worst_share = GENERATE(1.0, 0.5);
  test::same_by_threads({1, 2}, [&] {
    auto training = fixture.training(2);
    while (!training.finished()) training.step();
    return training.parameter();
  });
}

TEST_CASE("threads share a step a few times, whatever the number of layers", "[camouflage][training]") {
  const test::Threads cap(2);
  Fixture fixture;
  REQUIRE(fixture.objective.prefers_views_side_by_side());
  auto training = fixture.training(2, {0, 1, 2});
  training.step();  // prepares the views
  const auto& pool = detail::ThreadPool::instance();
  const std::size_t before = pool.loop_count();
  training.step();
  CHECK(pool.loop_count() - before >= 1);
  CHECK(pool.loop_count() - before <= 4);  // views, their gradients, the sum, the update
}

TEST_CASE("a step prepares the views of the next, and the last one none", "[camouflage][training]") {
  Fixture fixture;
  std::atomic<int> loads{0};
  auto settings = fixture.store.settings();
  settings.keep_bytes = 0;  // every view is prepared for each step that takes it
  auto store = test::tiny_store<float>(fixture.car, 4, settings, [&](std::size_t i) {
    ++loads;
    return test::tiny_frame(i);
  });
  camouflage::TrainingOptions options;
  options.epochs = 2;
  options.batch = 3;
  camouflage::Training<float> training(fixture.objective, store, {0, 1, 2, 3}, fixture.start, options);
  std::vector<int> after;  // steps take 3, 1, 3, 1 views
  while (!training.finished()) {
    training.step();
    after.push_back(loads);
  }
  CHECK(after == std::vector{4, 7, 8, 8});
}

TEST_CASE("a shared training gives the same bits for any number of processes", "[camouflage][training]") {
  const double worst_share = GENERATE(1.0, 0.5);
  Fixture plain;
  plain.worst_share = worst_share;
  auto alone = plain.training(2);
  while (!alone.finished()) alone.step();
  const auto shared = [=](std::size_t processes) {  // a thread each
    std::vector<std::vector<double>> blocks(processes);
    std::vector<Array<float, 2>> results(processes);
    std::barrier meeting(static_cast<std::ptrdiff_t>(processes));
    std::vector<std::thread> threads;
    for (std::size_t own = 0; own < processes; ++own)
      threads.emplace_back([&, own] {
        Fixture fixture;
        fixture.worst_share = worst_share;
        auto training = fixture.training(2);
        training.share({processes, own, [&](const std::vector<double>& values) {
                          blocks[own] = values;
                          meeting.arrive_and_wait();
                          std::vector<double> all;
                          for (const auto& block : blocks) all.insert(all.end(), block.begin(), block.end());
                          meeting.arrive_and_wait();
                          return all;
                        }});
        while (!training.finished()) training.step();
        results[own] = training.parameter();
      });
    for (auto& thread : threads) thread.join();
    for (const auto& result : results) CHECK((result == results.front()));
    return results.front();
  };
  for (const std::size_t processes : {1U, 2U, 3U, 4U})  // four are more than views in a step
    CHECK((shared(processes) == alone.parameter()));
}

TEST_CASE("a step learns from the worst share of its views", "[camouflage][training][worst_views]") {
  Fixture fixture;
  std::vector<double> losses;
  std::vector<Array<float, 2>> gradients;
  for (std::size_t i = 0; i < 4; ++i) {
    test::ActiveTape<float> tape;
    const ArrayVariable<float, 2> parameter = tape.input(fixture.start);
    const auto view = fixture.store.view(i);
    const auto value = fixture.objective(parameter, std::span(&view, 1));
    losses.push_back(static_cast<double>(value.value()));
    tape.reverse(value);
    gradients.push_back(parameter.adjoint());
  }
  fixture.batch = 4;
  fixture.worst_share = 0.4;  // the worst of four views and 0.6 of the next
  auto training = fixture.training(1);
  training.step();
  const auto weights = camouflage::worst_view_weights(losses, 0.4);
  double total = 0;
  for (std::size_t i = 0; i < 4; ++i) total += weights[i] * losses[i];
  CHECK(training.history().back().total == Approx(total).epsilon(1e-6));
  const auto first_moment = training.state().adam.first_moment;  // a tenth of the first gradient
  double largest = 0, distance = 0;
  for (std::size_t k = 0; k < first_moment.size(); ++k) {
    double expected = 0;
    for (std::size_t i = 0; i < 4; ++i)
      expected += 0.1 * weights[i] * static_cast<double>(gradients[i].data()[k]);
    largest = std::max(largest, std::abs(expected));
    distance = std::max(distance, std::abs(static_cast<double>(first_moment[k]) - expected));
  }
  CHECK(largest > 0);
  CHECK(distance <= 1e-5 * largest);
}

TEST_CASE("the worst views are chosen as they are photographed", "[camouflage][training][worst_views]") {
  Fixture fixture;
  fixture.batch = 4;
  fixture.conditions = image::conditions_by_names({"light", "noise"});
  fixture.worst_share = 1;
  auto all = fixture.training(1);
  all.step();
  // With a share of one view, the loss is the largest of the four; with shares of ¼ to 1, their means.
  fixture.worst_share = 0.25;
  auto one = fixture.training(1);
  one.step();
  const double largest = one.history().back().total;
  std::vector<double> losses;
  for (const double share : {0.5, 0.75, 1.0}) {
    fixture.worst_share = share;
    auto some = fixture.training(1);
    some.step();
    losses.push_back(some.history().back().total);
  }
  CHECK(losses.back() == Approx(all.history().back().total));
  const double second = 2 * losses[0] - largest, third = 3 * losses[1] - 2 * losses[0];
  const double fourth = 4 * losses[2] - 3 * losses[1];
  CHECK(largest >= second);
  CHECK(second >= third - 1e-6);
  CHECK(third >= fourth - 1e-6);
  CHECK(largest > fourth);
}

TEST_CASE("worst views that are none are refused, and NaN among them stops a step",
          "[camouflage][training][worst_views]") {
  Fixture fixture;
  for (const double share : {0.0, 1.01, std::numeric_limits<double>::quiet_NaN()}) {
    fixture.worst_share = share;
    CHECK_THROWS_WITH(fixture.training(1), contains("training: the worst share of views is"));
  }
  fixture.worst_share = 0.5;
  auto training = fixture.training(2);
  test::spoil(fixture.network);
  CHECK_THROWS_WITH(training.step(), contains("step 1: term"));
  CHECK(training.parameter() == fixture.start);
}

TEST_CASE("NaN in the loss stops the training, names step and term, and keeps the state",
          "[camouflage][training]") {  // T01
  Fixture fixture;
  auto training = fixture.training(2);
  training.step();
  const auto before = training.parameter();
  test::spoil(fixture.network);
  CHECK_THROWS_AS(training.step(), NumericError);
  CHECK_THROWS_WITH(training.step(), contains("step 2: term") && contains("frame"));
  CHECK(training.parameter() == before);
  CHECK(training.steps_taken() == 1);
}

TEST_CASE("training without a view that shows the car is refused", "[camouflage][training]") {  // T06
  Fixture fixture;
  CHECK_THROWS_AS(fixture.training(1, {}), Error);
}

TEST_CASE("a car outside the frame, or behind an all-zero mask, is hidden", "[camouflage][view]") {
  const auto car = test::tiny_car();
  auto frame = test::tiny_frame(0);
  frame.mask = tapestry::filled<std::uint8_t, 2>({48, 48}, std::uint8_t(0));
  const auto masked = camouflage::make_view<float>(frame, car, 48, 48);
  CHECK(masked.visible_pixels == 0);
  CHECK(masked.target.w == 0);
  frame = test::tiny_frame(0);
  frame.camera = geometry::look_at({30, 0, 1}, {60, 0, 1}, {0, 0, 1}, 0.9);
  CHECK(camouflage::make_view<float>(frame, car, 48, 48).visible_pixels == 0);
}

TEST_CASE("a view knows from where it is taken and how much of the car the frame's mask hides",
          "[camouflage][view]") {
  const auto car = test::tiny_car();
  const auto bounds = geometry::bounds_of(car.mesh.positions);
  auto frame = test::tiny_frame(0);
  frame.camera = geometry::orbit_camera(2, 0.3, 4 * bounds.half_length(), bounds.middle(), 0.9);
  const auto bare = camouflage::make_view<double>(frame, car, 48, 48);
  CHECK(bare.orbit.azimuth_rad == Approx(2));
  CHECK(bare.orbit.elevation_rad == Approx(0.3));
  CHECK(bare.orbit.distance == Approx(4));
  CHECK(bare.hidden_share == 0);
  frame.mask = tapestry::filled<std::uint8_t, 2>({48, 48}, std::uint8_t(0));
  double left = 0, all = 0;
  const auto& [top, from, height, width] = bare.window;
  for (std::size_t y = 0; y < 48; ++y)
    for (std::size_t x = 0; x < 48; ++x) {
      (*frame.mask)(y, x) = x < from + width / 2 ? 1 : 0;
      if (y < top || y >= top + height || x < from || x >= from + width) continue;
      all += bare.paint_to_picture->coverage(y - top, x - from);
      if (x < from + width / 2) left += bare.paint_to_picture->coverage(y - top, x - from);
    }
  REQUIRE(left < all);
  CHECK(camouflage::make_view<double>(frame, car, 48, 48).hidden_share == Approx(1 - left / all));
  frame.mask = std::nullopt;
  frame.image = tapestry::filled<std::uint8_t, 3>({24, 48, 3}, std::uint8_t(9));
  frame.camera->tan_half_fov_y /= 8;  // cuts the car, above and below
  const auto wide = camouflage::make_view<double>(frame, car, 48, 48);
  CHECK(wide.window.height == 24);
  CHECK(wide.hidden_share == 0);
  frame.camera = geometry::look_along(bounds.middle(), {1, 0, 0}, {0, 0, 1});
  CHECK(camouflage::make_view<double>(frame, car, 48, 48).orbit.distance == 0);
}

TEST_CASE("a target that touches the border ends there", "[camouflage][view]") {
  const auto car = test::tiny_car();
  auto frame = test::tiny_frame(0);
  frame.camera = geometry::look_at({3.5, 0.4, 1}, {0, 0, 0.7}, {0, 0, 1}, 0.9);
  const auto view = camouflage::make_view<float>(frame, car, 48, 48);
  REQUIRE(view.visible_pixels > 0);
  CHECK(view.target.cx - view.target.w / 2 >= 0);
  CHECK(view.target.cx + view.target.w / 2 <= 48);
  CHECK(view.target.w == 48);
}

TEST_CASE("a wide frame is letterboxed with the car where the frame shows it", "[camouflage][view]") {
  const auto car = test::tiny_car();
  auto frame = test::tiny_frame(0, 48);
  const auto square = camouflage::make_view<double>(frame, car, 48, 48);
  frame.image = tapestry::filled<std::uint8_t, 3>({24, 48, 3}, std::uint8_t(9));
  frame.camera->tan_half_fov_y /= 2;  // the middle half of the square frame
  const auto wide = camouflage::make_view<double>(frame, car, 48, 48);
  CHECK(wide.background(0, 0, 0) == 0.5);
  const auto coverage = [](const camouflage::View<double>& view, std::size_t y, std::size_t x) {
    const auto& [top, left, height, width] = view.window;
    const bool is_inside = y >= top && y < top + height && x >= left && x < left + width;
    return is_inside ? view.paint_to_picture->coverage(y - top, x - left) : 0;
  };
  for (std::size_t y = 0; y < 48; ++y)
    for (std::size_t x = 0; x < 48; ++x)
      REQUIRE(coverage(wide, y, x) == (y >= 12 && y < 36 ? coverage(square, y, x) : 0));
}

TEST_CASE("the car is drawn where a frame that is stretched or in the corner shows it",
          "[camouflage][view]") {
  using image::FitKind;
  const auto car = test::tiny_car();
  const bool is_wide = GENERATE(true, false);
  auto frame = test::tiny_frame(1);
  frame.image = test::random_array<std::uint8_t>({is_wide ? 24U : 48U, is_wide ? 48U : 24U, 3}, 1, 0, 255);
  (is_wide ? frame.camera->tan_half_fov_y : frame.camera->tan_half_fov_x) /= 2;
  const auto alone = camouflage::make_view<double>(frame, car, frame.image.shape(0), frame.image.shape(1));
  REQUIRE(alone.visible_pixels > 100);
  const auto colours = camouflage::own_colours<double>(car);
  const auto expected = camouflage::picture_of(alone, colours);

  const image::Fit corner{FitKind::letterbox_top_left, 114.0 / 255};
  const auto placed = camouflage::make_view<double>(frame, car, 48, 48, 2, corner);
  CHECK(placed.visible_pixels == alone.visible_pixels);
  CHECK(placed.target.cx == alone.target.cx);
  CHECK(placed.target.cy == alone.target.cy);
  const auto picture = camouflage::picture_of(placed, colours);
  double largest = 0;
  for (std::size_t y = 0; y < 48; ++y)
    for (std::size_t x = 0; x < 48; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const bool is_inside = y < expected.shape(0) && x < expected.shape(1);
        largest =
            std::max(largest, std::abs(picture(y, x, c) - (is_inside ? expected(y, x, c) : corner.fill)));
      }
  CHECK(largest <= 1e-9);  // the shear's rounding, times the slopes of the paint

  // A stretched frame is one that a camera of the same field of view took with other pixels.
  const auto stretched = camouflage::make_view<double>(frame, car, 48, 48, 2, {FitKind::stretch, 0});
  frame.image = tapestry::filled<std::uint8_t, 3>({48, 48, 3}, std::uint8_t(0));
  const auto whole = camouflage::make_view<double>(frame, car, 48, 48);
  CHECK((stretched.paint_to_picture->coverage == whole.paint_to_picture->coverage));
  CHECK(stretched.target.w == whole.target.w);
  CHECK(stretched.background(47, 47, 0) != 0);
}

TEST_CASE("a mask of another size is refused with both sizes", "[camouflage][view]") {
  auto frame = test::tiny_frame(0);
  frame.mask = tapestry::filled<std::uint8_t, 2>({47, 48}, std::uint8_t(1));
  CHECK_THROWS_WITH(camouflage::make_view<float>(frame, test::tiny_car(), 48, 48),
                    "make_view: mask is [47, 48], expected [48, 48]");
}

TEST_CASE("own colours give the clean car, in an atlas and in cubes", "[camouflage][texture]") {
  for (const auto kind : {raster::TextureKind::atlas, raster::TextureKind::cube}) {
    auto car = test::tiny_car(12, kind);
    car.space = GENERATE(image::ColourSpace::encoded, image::ColourSpace::linear);
    car.layout.filter = GENERATE(raster::TextureFilter::bilinear, raster::TextureFilter::anisotropic);
    car.pyramid = raster::pyramid_of(car);
    const auto colours = camouflage::own_colours<float>(car);
    auto unpainted = car;
    for (auto& face : unpainted.painted) face = 0;
    const auto view = camouflage::make_view<float>(test::tiny_frame(1), car, 48, 48);
    const auto plain = camouflage::make_view<float>(test::tiny_frame(1), unpainted, 48, 48);
    const auto painted = camouflage::picture_of(view, colours);
    const auto expected = camouflage::picture_of(plain, colours);
    for (std::size_t i = 0; i < painted.size(); ++i)
      REQUIRE(std::abs(painted.data()[i] - expected.data()[i]) < 1e-5F);
  }
}

TEST_CASE("white paint in the shade and in the light looks the same in both colour spaces",
          "[camouflage][view]") {
  using image::ColourSpace;
  auto car = test::tiny_car();
  auto frame = test::tiny_frame(1);
  const auto white = tapestry::filled<double, 2>({car.layout.texel_count(car.mesh), 3}, 1.0);
  const auto picture_in = [&](ColourSpace space) {
    car.space = space;
    return camouflage::picture_of(camouflage::make_view<double>(frame, car, 48, 48, 1), white);
  };
  const auto& eye = geometry::eye_of(*frame.camera);
  const auto normal = raster::seen_normal(car.mesh, 8, eye);  // of the roof
  for (const double side : {-1.0, 1.0}) {                     // away from the light, towards it
    frame.light = raster::Light{0.3, 0.6, geometry::scale(normal, side), {1, 1, 1}};
    std::fill(car.painted.begin(), car.painted.end(), std::uint8_t(0));
    for (const std::size_t roof : {8U, 9U}) car.painted[roof] = 1;
    const auto encoded = picture_in(ColourSpace::encoded), linear = picture_in(ColourSpace::linear);
    const double level = side < 0 ? 0.3 : 0.9;
    std::size_t of_roof = 0;
    for (std::size_t i = 0; i < encoded.size(); ++i) {
      if (std::abs(encoded.data()[i] - level) > 1e-9) continue;
      ++of_roof;
      REQUIRE(linear.data()[i] == Approx(level).epsilon(1e-9));
    }
    CHECK(of_roof > 100);
  }
}

TEST_CASE("a filtered atlas needs its pyramid, and views of one car share it", "[camouflage][view]") {
  Fixture fixture;
  const auto frame = test::tiny_frame(1);
  auto car = test::tiny_car();
  car.layout.filter = raster::TextureFilter::anisotropic;
  CHECK_THROWS_AS(camouflage::make_view<float>(frame, car, 48, 48), DomainError);
  std::vector<std::shared_ptr<const camouflage::View<float>>> views;
  for (int i = 0; i < 2; ++i) {
    car.pyramid = raster::pyramid_of(car);
    views.push_back(
        std::make_shared<const camouflage::View<float>>(camouflage::make_view<float>(frame, car, 48, 48)));
  }
  const auto white = tapestry::filled<float, 2>({car.layout.texel_count(car.mesh), 3}, 1.0F);
  const auto bilinear = camouflage::make_view<float>(frame, test::tiny_car(), 48, 48);
  CHECK(test::relative_distance(camouflage::picture_of(*views[0], white),
                                camouflage::picture_of(bilinear, white)) <= 1e-6);
  const ArrayVariable<float, 2> colours(fixture.start);
  CHECK_THROWS_WITH(fixture.objective(colours, views), "objective: views of different pyramids");
  car.layout.filter = raster::TextureFilter::bilinear;
  CHECK_THROWS_AS(camouflage::make_view<float>(frame, car, 48, 48), DomainError);
}

TEST_CASE("views in different colour spaces are refused", "[camouflage][objective]") {
  Fixture fixture;
  auto car = fixture.car;
  std::vector<std::shared_ptr<const camouflage::View<float>>> views;
  for (const auto space : image::colour_spaces) {
    car.space = space;
    views.push_back(std::make_shared<const camouflage::View<float>>(
        camouflage::make_view<float>(test::tiny_frame(1), car, 48, 48)));
  }
  const ArrayVariable<float, 2> colours(fixture.start);
  CHECK_THROWS_WITH(fixture.objective(colours, views), "objective: views in different colour spaces");
}

TEST_CASE("one view and one painted face train", "[camouflage][training]") {
  Fixture fixture;
  std::fill(fixture.car.painted.begin(), fixture.car.painted.end(), std::uint8_t(0));
  fixture.car.painted[8] = 1;  // half of the roof
  auto training = fixture.training(3, {0});
  while (!training.finished()) training.step();
  CHECK(std::isfinite(training.history().back().total));
}

TEST_CASE("an atlas that is repeated often is exported as it is", "[camouflage][texture]") {
  auto car = test::tiny_car();
  for (auto& uv : car.mesh.uvs) uv = {50 * uv[0], uv[1]};
  const auto colours = test::random_array<float>({car.layout.texel_count(car.mesh), 3}, 3);
  const auto atlas = camouflage::atlas_of(car, colours);
  REQUIRE(atlas.size() == colours.size());
  CHECK(std::equal(atlas.data(), atlas.data() + atlas.size(), colours.data()));
}

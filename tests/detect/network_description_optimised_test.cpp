#include <tapestry/detect/kept_picture.hpp>

#include "../support/differential.hpp"
#include "../support/kept_pass.hpp"
#include "../support/random_cfg.hpp"
#include "../support/random_model.hpp"

using namespace tapestry;

TEST_CASE("a batch of pictures has the bits of each alone", "[detect][network][differential][batch]") {
  test::DifferentialRun run("batches of networks of operators", 2);
  while (run.next()) {
    const test::RandomCfg cfg(run.seed());
    INFO(run.repeat() << "\n" << cfg.text());
    const auto layers = test::random_model<float>(cfg.config(), run.seed());
    const nn::Network<float> network(detect::network_description(layers.config(), layers.parameters()), {},
                                     true);
    constexpr std::size_t batch = 3;
    const std::size_t size = 3 * layers.input_height() * layers.input_width();
    const auto pictures = test::random_array<float>({batch, size}, run.seed());
    nn::Buffer<float> input;
    input.resize(pictures.size());
    std::copy_n(pictures.data(), pictures.size(), input.data());
    nn::NetworkPass<float> together, alone;
    network.forward({input.data()}, together, nn::Mode::input_gradient, batch);
    std::vector<const float*> adjoints;
    for (std::size_t i = 0; i < network.output_count(); ++i) adjoints.push_back(together.output(i));
    std::vector<float> gradient(pictures.size(), 0.F), expected(pictures.size(), 0.F);
    network.adjoint(together, adjoints, {gradient.data()});
    for (std::size_t n = 0; n < batch; ++n) {
      network.forward({input.data() + n * size}, alone, nn::Mode::input_gradient);
      for (std::size_t i = 0; i < network.output_count(); ++i) {
        const std::size_t count = nn::size_of(network.output_shape(i));
        adjoints[i] = alone.output(i);
        REQUIRE(std::equal(adjoints[i], adjoints[i] + count, together.output(i) + n * count));
      }
      network.adjoint(alone, adjoints, {expected.data() + n * size});
    }
    REQUIRE(gradient == expected);
  }
}

TEST_CASE("a picture that changes within a window has the bits of a whole pass through operators",
          "[detect][network][differential][kept]") {
  test::DifferentialRun run("windows of networks of operators", 4);
  double kept_share = 0;
  while (run.next()) {
    const test::RandomCfg cfg(run.seed());
    INFO(run.repeat() << "\n" << cfg.text());
    Random random(run.seed());
    const auto layers = test::random_model<float>(cfg.config(), run.seed());
    nn::Network<float> network(detect::network_description(layers.config(), layers.parameters()), {}, true);
    constexpr nn::Engine engines[] = {nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2,
                                      nn::Engine::winograd_f4};
    network.set_engine(engines[random.index(4)]);
    const std::size_t height = layers.input_height(), width = layers.input_width();
    image::PixelWindow window{random.index(height), random.index(width), 0, 0};
    window.height = random.index(std::min(height - window.top, 1 + height / 2) + 1);
    window.width = random.index(std::min(width - window.left, 1 + width / 2) + 1);
    const nn::MapWindow changed = detect::rows_and_columns(window);
    kept_share += network.share_kept(changed);
    auto picture = test::random_array<float>({1, height, width, 3}, run.seed());
    nn::Buffer<float> input;
    input.resize(picture.size());
    nn::KeptValues<float> kept;
    nn::NetworkPass<float> within, whole;
    const auto mode = random.chance(0.8) ? nn::Mode::input_gradient : nn::Mode::inference;
    for (int step = 0; step < 3; ++step) {
      test::repaint(picture, 0, window, random);
      std::copy_n(picture.data(), picture.size(), input.data());
      network.forward_within(input.data(), changed, kept, within, mode);
      network.forward({input.data()}, whole, mode);
      CAPTURE(step);
      std::vector<const float*> adjoints;
      for (std::size_t i = 0; i < network.output_count(); ++i) {
        const std::size_t count = nn::size_of(network.output_shape(i));
        REQUIRE(std::equal(within.output(i), within.output(i) + count, whole.output(i)));
        adjoints.push_back(whole.output(i));
      }
      if (mode == nn::Mode::inference) continue;
      std::vector<float> gradient(picture.size(), 0.F), expected(picture.size(), 0.F);
      network.adjoint(within, adjoints, {gradient.data()});
      network.adjoint(whole, adjoints, {expected.data()});
      for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
          for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t i = (y * width + x) * 3 + c;
            const float wanted = test::is_inside(window, y, x) ? expected[i] : 0.F;
            if (gradient[i] != wanted) REQUIRE(gradient[i] == wanted);
          }
    }
  }
  CHECK(kept_share > 0);
}

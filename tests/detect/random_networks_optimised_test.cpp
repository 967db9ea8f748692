#include <tapestry/detect/kept_picture.hpp>

#include "../support/differential.hpp"
#include "../support/finite_difference.hpp"
#include "../support/kept_pass.hpp"
#include "../support/random_cfg.hpp"
#include "../support/random_model.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using image::PixelWindow;

namespace {
constexpr nn::Engine engines[] = {nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2,
                                  nn::Engine::winograd_f4, nn::Engine::bfloat16};

/// A random model, the engine of its detectors and a batch of pictures.
struct Case {
  test::RandomCfg cfg;
  Random random;
  detect::DarknetModel<double> model;
  nn::Engine engine;
  Array<double, 4> images;

  explicit Case(std::uint64_t seed)
      : cfg(seed),
        random(seed),
        model(test::random_model<double>(cfg.config(), seed)),
        engine(engines[random.index(std::size(engines))]),
        images(random_array<double>({1 + random.index(3), model.input_height(), model.input_width(), 3},
                                    seed)) {}

  /// A detector of a model of the same cfg; in training mode with the statistics of the batch.
  template <class T>
  [[nodiscard]] detect::Detector<T> detector(const detect::DarknetModel<T>& of,
                                             detect::Mode mode = detect::Mode::inference,
                                             const std::vector<std::string>& layers = {}) const {
    auto made = mode == detect::Mode::training ? of.learning_detector() : of.detector(layers);
    made.set_engine(engine);
    return made;
  }

  /// The text that repeats it, with or without this generator.
  [[nodiscard]] std::string text() const {
    return cfg.text() + "# engine " + std::string(nn::name_of(engine)) + ", " +
           std::to_string(images.shape(0)) + " images";
  }
};

PixelWindow random_window(std::size_t height, std::size_t width, Random& random) {
  PixelWindow window;
  window.top = random.index(height);
  window.left = random.index(width);
  window.height = random.index(std::min(height - window.top, 1 + height / 2) + 1);
  window.width = random.index(std::min(width - window.left, 1 + width / 2) + 1);
  return window;
}

template <class T>
void require_same_bits(const detect::Detector<T>& detector, Array<T, 4> images, Random& random) {
  const auto mode = random.chance(0.8) ? detect::Mode::input_gradient : detect::Mode::inference;
  const std::size_t height = detector.input_height(), width = detector.input_width();
  std::vector<PixelWindow> windows;
  std::vector<detect::KeptPicture<T>> pictures;
  std::vector<bool> is_kept;
  for (std::size_t i = 0; i < images.shape(0); ++i) {
    is_kept.push_back(random.chance(0.85));
    windows.push_back(is_kept[i] ? random_window(height, width, random) : PixelWindow{0, 0, height, width});
    pictures.emplace_back(windows[i]);
  }
  std::vector<detect::KeptPicture<T>*> kept;
  for (std::size_t i = 0; i < pictures.size(); ++i) kept.push_back(is_kept[i] ? &pictures[i] : nullptr);
  detect::Pass<T> kept_pass, whole_pass;
  for (int step = 0; step < 3; ++step) {
    for (std::size_t i = 0; i < windows.size(); ++i) test::repaint(images, i, windows[i], random);
    detector.forward_within(images, kept, kept_pass, mode);
    detector.forward(images, whole_pass, mode);
    CAPTURE(step);
    REQUIRE(differences(kept_pass.logits, whole_pass.logits) == 0);
    if (mode == detect::Mode::input_gradient)
      REQUIRE(test::adjoint_differences(detector, kept_pass, whole_pass, windows, random) == 0);
  }
}

using Weighting = std::vector<Array<double, 4>>;

/// Σ |weight · logit|, whose multiple of ε bounds the rounding of their sum.
double magnitude(const detect::Pass<double>& pass, const Weighting& weighting) {
  double sum = 0;
  for (std::size_t h = 0; h < weighting.size(); ++h)
    for (std::size_t i = 0; i < weighting[h].size(); ++i)
      sum += std::abs(pass.logits[h].data()[i] * weighting[h].data()[i]);
  return sum;
}

/// Derivative at 0 of a function of the step, and its largest error.
struct Slope {
  double value, tolerance;
};

/// Central differences at two steps, of the largest pair that agrees; nothing if kinks or rounding let no
/// pair agree. The two differ, except by chance, with a kink in reach or a step that is too long.
template <class Function>
std::optional<Slope> central_slope(Function f, double rounding) {
  for (const double h : {1e-4, 1e-5, 1e-6, 1e-7}) {
    const double far = (f(h) - f(-h)) / (2 * h), near = (f(h / 4) - f(-h / 4)) / (h / 2);
    const double tolerance = 1e-6 * std::max(std::abs(far), std::abs(near)) + 4 * rounding / h;
    if (std::abs(far - near) < tolerance / 2) return Slope{near, tolerance};
  }
  return std::nullopt;
}

/// A direction of length one within the values [begin, end), few or all of them.
template <std::size_t Rank>
Array<double, Rank> direction_within(Array<double, Rank> direction, std::size_t begin, std::size_t end,
                                     Random& random) {
  std::fill_n(direction.data(), direction.size(), 0.0);
  const double share = random.chance(0.5) ? 1 : 0.05;
  double squares = 0;
  const std::size_t one = begin + random.index(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    if (i != one && !random.chance(share)) continue;
    direction.data()[i] = random.uniform(-1, 1);
    squares += direction.data()[i] * direction.data()[i];
  }
  for (double& value : direction.storage()) value /= std::sqrt(squares);
  return direction;
}

struct Counts {
  std::size_t compared = 0, kinked = 0;
};

/// Compares the adjoints of a pass with differences of its values.
class DifferenceCheck {
 public:
  DifferenceCheck(Case& drawn, detect::Mode mode)
      : case_(drawn), detector_(drawn.detector(drawn.model, mode)), mode_(mode) {
    detector_.forward(case_.images, pass_, mode_);
    weighting_ = test::weighting_of(pass_, case_.random);
    for (auto& head : weighting_) {
      if (weighting_.size() > 1 && case_.random.chance(0.2)) std::fill_n(head.data(), head.size(), 0.0);
      pointers_.push_back(std::ranges::all_of(head.storage(), [](double w) { return w == 0; }) ? nullptr
                                                                                               : &head);
    }
    const double value = test::dot(pass_.logits, weighting_);
    rounding_ = 64 * epsilon * magnitude(pass_, weighting_);
    for (int trial = 0; trial < 2; ++trial) {  // change of the result by rounding the first layer's input
      auto moved = case_.images;
      for (double& x : moved.storage()) x *= 1 + 8 * epsilon * case_.random.uniform(-1, 1);
      rounding_ += std::abs(value_at(moved) - value);
    }
  }

  void check_images(Counts& counts) {
    auto gradient = tapestry::zeros<double, 4>(case_.images.shape());
    for (int half = 0; half < 2; ++half) detector_.pull_back(pass_, pointers_, &gradient);  // adjoints add
    for (int trial = 0; trial < 3; ++trial) {
      const auto direction = direction_within(case_.images, 0, case_.images.size(), case_.random);
      const auto value = [&](double step) { return value_at(moved(case_.images, direction, step)); };
      INFO("images");
      compare(0.5 * test::dot(gradient, direction), value, counts);
    }
  }

  void check_weights(Counts& counts) {
    const Array<double, 1> start = detector_.weights();
    auto gradient = tapestry::zeros<double, 1>({start.size()});
    for (int half = 0; half < 2; ++half) detector_.pull_back(pass_, pointers_, nullptr, &gradient);
    for (const auto& block : detector_.network().weight_blocks()) {
      const auto direction =
          direction_within(start, block.offset, block.offset + nn::size_of(block.shape), case_.random);
      const auto value = [&](double step) {
        detector_.set_weights(moved(start, direction, step));
        return value_at(case_.images);
      };
      INFO(block.name);
      compare(0.5 * test::dot(gradient, direction), value, counts);
      detector_.set_weights(start);
    }
  }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  template <class Array>
  [[nodiscard]] static Array moved(Array at, const Array& direction, double step) {
    for (std::size_t i = 0; i < at.size(); ++i) at.data()[i] += step * direction.data()[i];
    return at;
  }

  [[nodiscard]] double value_at(const Array<double, 4>& images) {
    detector_.forward(images, other_, mode_);
    return test::dot(other_.logits, weighting_);
  }

  template <class Function>
  void compare(double derivative, Function value, Counts& counts) {
    const auto slope = central_slope(value, rounding_);
    ++(slope ? counts.compared : counts.kinked);
    if (!slope) return;
    CAPTURE(derivative, slope->value, slope->tolerance, rounding_);
    REQUIRE(std::abs(derivative - slope->value) <= slope->tolerance);
  }

  Case& case_;
  detect::Detector<double> detector_;
  detect::Mode mode_;
  detect::Pass<double> pass_, other_;
  Weighting weighting_;
  std::vector<const Array<double, 4>*> pointers_;
  double rounding_ = 0;
};

/// The values of all heads together.
template <class T>
std::vector<double> joined(const std::vector<Array<T, 4>>& arrays) {
  std::vector<double> values;
  for (const auto& array : arrays) values.insert(values.end(), array.data(), array.data() + array.size());
  return values;
}

template <class T>
Array<T, 4> image_adjoint(const detect::Detector<T>& detector, detect::Pass<T>& pass,
                          const std::vector<Array<double, 4>>& weighting, const Array<double, 4>& images) {
  std::vector<Array<T, 4>> adjoint;
  for (const auto& head : weighting) adjoint.push_back(tapestry::cast<T>(head));
  auto gradient = tapestry::zeros<T, 4>(images.shape());
  detector.input_adjoint(pass, adjoint, gradient);
  return gradient;
}

/// Layers with a kink that copy_branches() does not hand over: relu6 and hard_mish.
std::vector<std::size_t> layers_of_other_kinks(const detect::NetworkConfig& config) {
  std::vector<std::size_t> layers;
  for (std::size_t i = 0; i < config.layers.size(); ++i)
    if (const auto activation = config.layers[i].activation;
        activation == nn::Activation::relu6 || activation == nn::Activation::hard_mish)
      layers.push_back(i);
  return layers;
}

/// Whether a value of such a layer lies on the other side of a kink in one of the passes; the detectors
/// observe all these layers.
template <class A, class B>
bool has_other_sides(const detect::NetworkConfig& config, const detect::Detector<A>& of_a,
                     const detect::Pass<A>& a, const detect::Detector<B>& of_b, const detect::Pass<B>& b) {
  const auto layers = layers_of_other_kinks(config);
  for (std::size_t layer = 0; layer < layers.size(); ++layer) {
    const bool is_relu6 = config.layers[layers[layer]].activation == nn::Activation::relu6;
    const auto side = [&](auto y) { return is_relu6 ? (y > 0 ? 1 : 0) + (y < 6 ? 1 : 0) : (y != 0 ? 1 : 0); };
    for (std::size_t n = 0; n < a.images; ++n) {
      const auto left = of_a.layer_values(a, layer, n);
      const auto right = of_b.layer_values(b, layer, n);
      for (std::size_t k = 0; k < left.size(); ++k)
        if (side(left.data()[k]) != side(right.data()[k])) return true;
    }
  }
  return false;
}

/// Changes every number by up to `unit` of itself.
template <std::size_t Rank>
Array<double, Rank> rounded(Array<double, Rank> array, double unit, Random& random) {
  for (double& x : array.storage()) x *= 1 + unit * random.uniform(-1, 1);
  return array;
}

/// Length of the difference of two arrays.
template <class A, class B>
double distance(const A& a, const B& b) {
  double squares = 0;
  for (std::size_t i = 0; i < b.size(); ++i)
    squares += std::pow(double(a.data()[i]) - double(b.data()[i]), 2);
  return std::sqrt(squares);
}

/// Errors of the float pass, divided by the errors of a pass in double with rounded operands, of
/// logits and of the gradient.
struct FloatErrors {
  double logits = 0, gradient = 0;
};

FloatErrors float_errors(Case& drawn) {
  const auto mode = detect::Mode::input_gradient;
  const bool is_bfloat16 = drawn.engine == nn::Engine::bfloat16;
  const double unit = std::ldexp(1.0, is_bfloat16 ? -9 : -24);
  const auto& config = drawn.model.config();
  std::vector<std::string> layers;
  for (const std::size_t layer : layers_of_other_kinks(config))
    layers.push_back(drawn.model.value_name(layer));
  auto moved_model = drawn.model;
  moved_model.parameters() = rounded(drawn.model.parameters(), unit, drawn.random);
  const auto exact = drawn.detector(drawn.model, mode, layers);
  const auto moved = drawn.detector(moved_model, mode, layers);
  const auto single = drawn.detector(drawn.model.cast<float>(), mode, layers);
  detect::Pass<double> pass, moved_pass;
  detect::Pass<float> single_pass;
  exact.forward(drawn.images, pass, mode);
  moved.forward(rounded(drawn.images, unit, drawn.random), moved_pass, mode);
  single.forward(tapestry::cast<float>(drawn.images), single_pass, mode);
  const auto over = [&](const auto& found, const auto& noisy, const auto& wanted, double scale) {
    const double error = distance(found, wanted), own = distance(wanted, std::vector<double>(wanted.size()));
    return error / (distance(noisy, wanted) + unit * (own + scale) + std::numeric_limits<double>::min());
  };
  FloatErrors errors;
  errors.logits = over(joined(single_pass.logits), joined(moved_pass.logits), joined(pass.logits), 0);
  if (has_other_sides(config, exact, pass, single, single_pass) ||
      has_other_sides(config, moved, moved_pass, single, single_pass))
    return errors;
  pass.copy_branches(single_pass);
  moved_pass.copy_branches(single_pass);
  const auto weighting = test::weighting_of(pass, drawn.random);
  errors.gradient = over(image_adjoint(single, single_pass, weighting, drawn.images),
                         image_adjoint(moved, moved_pass, weighting, drawn.images),
                         image_adjoint(exact, pass, weighting, drawn.images),
                         distance(joined(weighting), std::vector<double>(joined(weighting).size())));
  return errors;
}

/// Logits, then the adjoints of the pictures and, of a training pass, of the weights.
std::vector<Array<float, 4>> results_of(const detect::Detector<float>& detector,
                                        const Array<float, 4>& images, detect::Mode mode, int threads) {
  const test::Threads limit(threads);
  detect::Pass<float> pass;
  detector.forward(images, pass, mode);
  auto weighting = pass.logits;
  std::vector<const Array<float, 4>*> pointers;
  for (auto& head : weighting) {
    const std::size_t of_image = head.size() / images.shape(0);
    for (std::size_t i = 0; i < head.size(); ++i)  // the same for each image
      head.data()[i] = static_cast<float>(std::sin(1.0 + static_cast<double>(i % of_image)));
    pointers.push_back(&head);
  }
  auto gradient = tapestry::zeros<float, 4>(images.shape());
  auto of_weights = tapestry::zeros<float, 1>({detector.weights().size()});
  detector.pull_back(pass, pointers, &gradient, mode == detect::Mode::training ? &of_weights : nullptr);
  auto results = pass.logits;
  results.push_back(std::move(gradient));
  results.emplace_back(Extents<4>{1, 1, 1, of_weights.size()});
  std::copy_n(of_weights.data(), of_weights.size(), results.back().data());
  return results;
}

Array<float, 4> image_of(const Array<float, 4>& batch, std::size_t n) {
  Array<float, 4> image(Extents<4>{1, batch.shape(1), batch.shape(2), batch.shape(3)});
  std::copy_n(batch.data() + n * image.size(), image.size(), image.data());
  return image;
}
}  // namespace

TEST_CASE("random networks have the bits of a whole pass where pictures change within windows",
          "[detect][differential][kept][long]") {
  DifferentialRun run("windows of random networks", 8);
  while (run.next()) {
    Case drawn(run.seed());
    INFO(run.repeat() << "\n" << drawn.text());
    if (drawn.random.chance(0.5))
      require_same_bits<double>(drawn.detector(drawn.model), drawn.images, drawn.random);
    else
      require_same_bits<float>(drawn.detector(drawn.model.cast<float>()), tapestry::cast<float>(drawn.images),
                               drawn.random);
  }
}

TEST_CASE("gradients of random networks agree with central differences", "[detect][differential][gradient]") {
  DifferentialRun run("gradients of random networks", 8);
  Counts counts;
  while (run.next()) {
    Case drawn(run.seed());
    INFO(run.repeat() << "\n" << drawn.text());
    DifferenceCheck(drawn, detect::Mode::input_gradient).check_images(counts);
    DifferenceCheck training(drawn, detect::Mode::training);
    training.check_images(counts);
    training.check_weights(counts);
  }
  CHECK(counts.kinked <= counts.compared / 10);  // the others are compared
}

TEST_CASE("random networks in float follow double by every engine", "[detect][differential]") {
  DifferentialRun run("random networks in float", 4);
  while (run.next()) {
    Case drawn(run.seed());
    INFO(run.repeat() << "\n" << drawn.text());
    const auto [logits, gradient] = float_errors(drawn);
    // Sums of up to n = 7·7·48 terms round √n < 50 times as much as one, Winograd's twice as much again.
    REQUIRE(logits < 100);
    REQUIRE(gradient < 100);
  }
}

TEST_CASE("random networks give the same bits on any number of threads, and an image in any batch",
          "[detect][differential]") {
  DifferentialRun run("threads and batches of random networks", 4);
  while (run.next()) {
    Case drawn(run.seed());
    INFO(run.repeat() << "\n" << drawn.text());
    const auto model = drawn.model.cast<float>();
    const auto images = tapestry::cast<float>(drawn.images);
    const auto mode = drawn.random.chance(0.5) ? detect::Mode::training : detect::Mode::input_gradient;
    const auto either = drawn.detector(model, mode);
    REQUIRE(differences(results_of(either, images, mode, 1), results_of(either, images, mode, 3)) == 0);
    const auto detector = drawn.detector(model);
    const std::size_t n = drawn.random.index(images.shape(0));
    auto all = results_of(detector, images, detect::Mode::input_gradient, 2);
    const auto alone = results_of(detector, image_of(images, n), detect::Mode::input_gradient, 2);
    for (std::size_t i = 0; i + 1 < all.size(); ++i) all[i] = image_of(all[i], n);
    REQUIRE(differences(all, alone) == 0);
  }
}

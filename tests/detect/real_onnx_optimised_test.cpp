#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/kept_pass.hpp"
#include "../support/paths.hpp"
#include "../support/relative_distance.hpp"

using namespace tapestry;

namespace {
/// Detection of ONNX Runtime: confidence, then the box's centre and extents in pixels of the frame.
struct Expected {
  const char* frame;
  double confidence, cx, cy, w, h;
};

const std::string data = test::in_shared("data/");
constexpr std::size_t car = 2;

const std::vector<std::pair<std::string, std::vector<Expected>>> table = {
    {"yolox_nano",
     {{"data1", .833, 398.6, 403.6, 418.4, 179.3},
      {"data12501", .879, 397.3, 400.2, 419.4, 160.0},
      {"data12502", .860, 399.6, 433.1, 246.9, 274.9},
      {"data12503", .857, 392.3, 401.0, 409.9, 168.7},
      {"data12504", .871, 402.7, 434.8, 224.9, 233.9},
      {"data12505", .872, 352.0, 426.7, 356.3, 241.7}}},
    {"nanodet_m",
     {{"data1", .723, 398.9, 403.5, 428.3, 174.6},
      {"data12501", .726, 402.3, 404.9, 422.3, 155.0},
      {"data12502", .427, 401.5, 423.5, 239.3, 287.4},
      {"data12503", .690, 398.5, 400.6, 426.7, 162.7},
      {"data12504", .353, 400.9, 421.2, 232.3, 265.7},
      {"data12505", .744, 360.6, 427.6, 365.3, 236.7}}},
};

const std::vector<Expected> cars_of_yolov5n = {
    {"data1", .469, 397.8, 405.3, 433.4, 172.2},     {"data12501", .747, 400.6, 401.9, 410.0, 160.3},
    {"data12502", .256, 395.0, 433.4, 235.5, 274.2}, {"data12503", .630, 399.7, 397.2, 425.6, 167.5},
    {"data12504", .491, 401.9, 434.1, 217.2, 225.3}, {"data12505", .754, 365.9, 427.5, 355.0, 234.2}};

/// A frame of 800 × 800 as the networks take it, [1, size, size, 3], rounded to bytes as in the table.
template <class T>
Array<T, 4> network_input(const std::string& frame, std::size_t size = 416) {
  const auto picture = io::read_frame(data + "carla/" + frame + ".npz").image;
  Array<double, 3> colours(picture.shape());
  for (std::size_t i = 0; i < picture.size(); ++i) colours.data()[i] = static_cast<double>(picture.data()[i]);
  Array<T, 3> resized = tapestry::cast<T>(image::resize_bilinear(colours, size, size));
  for (T& value : resized.storage()) value = std::round(value) / 255;
  return image::batch_of(resized);
}

bool has_no_data() { return test::is_absent(data + "detectors/yolox_nano.onnx"); }

template <class T>
detect::Detector<T> load(const std::string& name) {
  const auto network = io::read_onnx(data + "detectors/" + name + ".onnx");
  const auto kind = detect::recognised_detector(network);
  REQUIRE(kind);
  return detect::Detector<T>(network, *kind);
}

template <class T>
detect::Detection best_car(const detect::Detector<T>& detector, const Array<T, 4>& input,
                           detect::Pass<T>& pass) {
  detector.forward(input, pass);
  detect::Detection best{};
  for (const auto& found :
       detect::decode(detector.heads(), pass.logits, 0, 0.1, detector.input_height(), detector.input_width()))
    if (found.class_index == car && found.confidence > best.confidence) best = found;
  return best;
}

void check_cars(const std::string& name, const detect::Detector<float>& detector,
                const std::vector<Expected>& cars, double tolerance = .002) {
  const std::size_t size = detector.input_height();
  const double scale = 800 / static_cast<double>(size);
  detect::Pass<float> pass;
  for (const Expected& expected : cars) {
    const auto found = best_car(detector, network_input<float>(expected.frame, size), pass);
    const auto& box = found.box;
    INFO(name << " " << expected.frame << ": " << found.confidence << " " << box.cx * scale << ","
              << box.cy * scale << " " << box.w * scale << " x " << box.h * scale);
    CHECK(std::abs(found.confidence - expected.confidence) <= tolerance);
    CHECK(std::abs(box.cx * scale - expected.cx) <= 1);
    CHECK(std::abs(box.cy * scale - expected.cy) <= 1);
    CHECK(std::abs(box.w * scale - expected.w) <= 1);
    CHECK(std::abs(box.h * scale - expected.h) <= 1);
  }
}
}  // namespace

TEST_CASE("trained networks from ONNX files find the cars that ONNX Runtime finds", "[detect][onnx][real]") {
  if (has_no_data()) return;
  for (const auto& [name, cars] : table) check_cars(name, load<float>(name), cars);
}

TEST_CASE("a trained network in half precision finds the cars that ONNX Runtime finds",
          "[detect][onnx][real]") {
  const std::string path = data + "detectors/yolov5n_fp16.onnx";
  if (test::is_absent(path)) return;
  const detect::Detector<float> detector(io::read_onnx(path), detect::known_description("yolov5"));
  // ONNX Runtime rounds the result of each of 60 layers by 2^-11: √60 · 2^-11 of a logit of 5 are .02, after
  // the logistic function at most a quarter of that.
  check_cars("yolov5n_fp16", detector, cars_of_yolov5n, .005);
}

TEST_CASE("the car's window of a frame has the bits of a whole pass through trained ONNX networks",
          "[detect][onnx][real][kept]") {
  if (has_no_data()) return;
  const std::string name = GENERATE("yolox_nano", "nanodet_m");
  CAPTURE(name);
  const auto detector = load<float>(name);
  auto images = network_input<float>("data12504");
  const image::PixelWindow window{165, 150, 122, 117};  // of the car, with a margin
  CHECK(detector.share_kept(window) > 0.25);
  Random random(1);
  detect::KeptPicture<float> picture(window);
  detect::Pass<float> kept, whole;
  for (int step = 0; step < 3; ++step) {
    test::repaint(images, 0, window, random);
    detector.forward_within(images, {&picture}, kept, detect::Mode::input_gradient);
    detector.forward(images, whole, detect::Mode::input_gradient);
    CHECK(test::differences(kept.logits, whole.logits) == 0);
    CHECK(test::adjoint_differences(detector, kept, whole, {window}, random) == 0);
  }
}

TEST_CASE("float follows double through trained ONNX networks", "[detect][onnx][real]") {
  if (has_no_data()) return;
  for (const auto& [name, cars] : table) {
    const auto single = load<float>(name);
    const auto twice = load<double>(name);
    detect::Pass<float> pass;
    detect::Pass<double> reference;
    single.forward(network_input<float>("data1"), pass);
    twice.forward(network_input<double>("data1"), reference);
    for (std::size_t h = 0; h < pass.logits.size(); ++h) {
      const double distance = test::relative_distance(pass.logits[h], reference.logits[h]);
      INFO(name << " head " << h << ": " << distance);
      CHECK(distance <= 5e-6);
    }
  }
}

namespace {
/// Where the logit of the surest car lies.
struct CarLogit {
  std::size_t head = 0, index = 0;
};

template <class T>
CarLogit surest_car(const std::vector<Array<T, 4>>& logits) {
  CarLogit best;
  T largest = -std::numeric_limits<T>::infinity();
  for (std::size_t h = 0; h < logits.size(); ++h) {
    const std::size_t cells = logits[h].shape(2) * logits[h].shape(3);
    const std::size_t plane = logits[h].shape(1) - 80 + car;  // the classes come last
    for (std::size_t i = plane * cells; i < (plane + 1) * cells; ++i)
      if (logits[h].data()[i] > largest) {
        largest = logits[h].data()[i];
        best = {h, i};
      }
  }
  return best;
}

template <class T>
Array<T, 4> gradient_of(const detect::Detector<T>& detector, const Array<T, 4>& input, CarLogit car_logit) {
  detect::Pass<T> pass;
  detector.forward(input, pass, nn::Mode::input_gradient);
  std::vector<Array<T, 4>> adjoints;
  for (const auto& logits : pass.logits) adjoints.push_back(tapestry::zeros<T, 4>(logits.shape()));
  adjoints[car_logit.head].data()[car_logit.index] = 1;
  auto gradient = tapestry::zeros<T, 4>(input.shape());
  detector.input_adjoint(pass, adjoints, gradient);
  return gradient;
}
}  // namespace

TEST_CASE("a car's gradient through trained ONNX networks is that of central differences",
          "[detect][onnx][real][long]") {
  if (has_no_data()) return;
  for (const auto& [name, cars] : table) {
    const auto twice = load<double>(name);
    const auto input = network_input<double>("data1");
    detect::Pass<double> pass;
    twice.forward(input, pass);
    const CarLogit car_logit = surest_car(pass.logits);
    const auto gradient = gradient_of(twice, input, car_logit);
    const double distance = test::relative_distance(
        gradient_of(load<float>(name), network_input<float>("data1"), car_logit), gradient);
    INFO(name << ": float differs by " << distance);
    CHECK(distance <= 2e-5);  // no kink is held
    Random random(5);
    for (int direction = 0; direction < 4; ++direction) {
      Array<double, 4> along(input.shape());
      for (double& part : along.storage()) part = random.normal();
      const double slope =
          std::inner_product(along.storage().begin(), along.storage().end(), gradient.data(), 0.0);
      const auto logit = [&](double distance_along) {
        twice.forward(Array<double, 4>(input + distance_along * along), pass);
        return pass.logits[car_logit.head].data()[car_logit.index];
      };
      // One of several steps crosses no kink of a Leaky ReLU and no tie of a pool.
      double error = std::numeric_limits<double>::infinity();
      for (const double step : {1e-7, 3e-8, 1e-8, 3e-9})
        error = std::min(error, std::abs((logit(step) - logit(-step)) / (2 * step) - slope));
      INFO("slope " << slope << ", off by " << error);
      CHECK(error <= 1e-6 * std::max(1.0, std::abs(slope)));
    }
  }
}

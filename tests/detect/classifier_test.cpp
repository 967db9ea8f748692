#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/io/darknet/model_file.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/random_model.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
const std::string classifier = test::cfg_text("classifier_layers");

/// With the layers from `name` on left out.
std::string without(const std::string& name) { return classifier.substr(0, classifier.find(name)); }

detect::DarknetModel<double> random_classifier(const std::string& cfg) {
  return test::random_model<double>(io::parse_classifier_config(cfg, "some.cfg"), 1);
}

double value(const detect::Detector<double>& detector, const Array<double, 4>& images,
             const Array<double, 4>& weights, detect::Mode mode) {
  detect::Pass<double> pass;
  detector.forward(images, pass, mode);
  return test::dot(weights, pass.logits.at(0));
}

constexpr double h = 1e-4;  // rounding 1e-16 / h, truncation of order h⁴
}  // namespace

TEST_CASE("reorg of 2 x 2 pixels of 4 channels is Darknet's by hand", "[detect][network][classifier]") {
  // Channel c holds c0, c1, c2, c3 in its pixels. Darknet's list 00 01 02 03 10 … 33, read as 4 x 4, gives
  // its even rows' even columns, odd columns, then its odd rows': 00 02 20 22, 01 03 21 23, 10 12 30 32, …
  const std::string cfg =
      "[net]\nwidth=2\nheight=2\nchannels=3\n[convolutional]\nfilters=4\nsize=1\nstride=1\n"
      "activation=linear\n[reorg]\nstride=2\n";
  Array<double, 1> parameters{0, 10, 20, 30, 1, 0, 0, 1,
                              0, 0,  1,  0,  0, 1, 0, 0};  // the first colour and 10·c
  const detect::DarknetModel<double> model(io::parse_classifier_config(cfg, "reorg.cfg"), parameters);
  auto picture = tapestry::zeros<double, 4>({1, 2, 2, 3});
  for (std::size_t pixel = 0; pixel < 4; ++pixel) picture.data()[3 * pixel] = static_cast<double>(pixel);
  const auto logits = detect::forward(model.detector(), picture);
  REQUIRE(logits.at(0).shape() == Extents<4>{1, 16, 1, 1});
  CHECK(std::vector<double>(logits[0].data(), logits[0].data() + 16) ==
        std::vector<double>{0, 2, 20, 22, 1, 3, 21, 23, 10, 12, 30, 32, 11, 13, 31, 33});
}

TEST_CASE("a classifier hands out the probabilities of its last layer", "[detect][classifier]") {
  const auto detector = random_classifier(classifier).detector();
  CHECK(detector.heads().empty());
  const auto images = random_array<double>({2, 16, 16, 3}, 2);
  const auto shares = detect::forward(detector, images);
  REQUIRE(shares.size() == 1);
  CHECK(shares[0].shape() == Extents<4>{2, 10, 1, 1});
  const auto logits = detect::forward(random_classifier(without("[softmax]")).detector(), images)[0];
  for (std::size_t n = 0; n < 2; ++n) {
    double sum = 0;
    for (std::size_t k = 0; k < 10; ++k) sum += std::exp(logits(n, k, 0, 0));
    for (std::size_t k = 0; k < 10; ++k)
      CHECK(shares[0](n, k, 0, 0) == Approx(std::exp(logits(n, k, 0, 0)) / sum).epsilon(1e-12));
  }
}

TEST_CASE("a classifier's gradients agree with central differences", "[detect][classifier][gradient]") {
  const std::string cfg = GENERATE(std::string(classifier), without("[softmax]"), without("[avgpool]"),
                                   without("[convolutional]\nfilters=10"));  // ends in a shortcut
  auto detector = random_classifier(cfg).learning_detector();
  const auto images = random_array<double>({2, 16, 16, 3}, 2);
  detect::Pass<double> pass;
  detector.forward(images, pass, detect::Mode::training);
  const auto& shape = pass.logits[0].shape();
  const auto weights = random_array<double>({shape[0], shape[1], shape[2], shape[3]}, 3, -1, 1);
  auto images_adjoint = tapestry::zeros<double, 4>(images.shape());
  const auto start = detector.weights();
  auto weights_adjoint = tapestry::zeros<double, 1>({start.size()});
  detector.pull_back(pass, {&weights}, &images_adjoint, &weights_adjoint);
  Random random(4);
  for (int trial = 0; trial < 8; ++trial) {
    const std::size_t i = random.index(images.size());
    const auto along = [&](double step) {
      auto moved = images;
      moved.data()[i] += step;
      return value(detector, moved, weights, detect::Mode::training);
    };
    CHECK(images_adjoint.data()[i] == Approx(fourth_order_difference(along, h)).epsilon(1e-7).margin(1e-8));
  }
  for (const auto& block : detector.network().weight_blocks()) {
    const std::size_t i = block.offset + random.index(nn::size_of(block.shape));
    const auto along = [&](double step) {
      auto moved = start;
      moved[i] += step;
      detector.set_weights(moved);
      return value(detector, images, weights, detect::Mode::training);
    };
    CHECK(weights_adjoint[i] == Approx(fourth_order_difference(along, h)).epsilon(1e-7).margin(1e-8));
  }
}

TEST_CASE("a classifier is one record on the tape", "[detect][classifier][gradient]") {
  const auto detector = random_classifier(classifier).detector();
  const auto start = random_array<double>({1, 16, 16, 3}, 2);
  ActiveTape<double> tape;
  const auto images = tape.input(start);
  const auto outputs = detect::forward(detector, images);
  REQUIRE(outputs.size() == 1);
  auto one = tapestry::zeros<double, 4>(outputs[0].value().shape());
  one(0, 3, 0, 0) = 1;
  tape.reverse(outputs[0], one);
  const std::size_t i = 123;
  const auto along = [&](double step) {
    auto moved = start;
    moved.data()[i] += step;
    return value(detector, moved, one, detect::Mode::inference);
  };
  CHECK(images.adjoint().data()[i] == Approx(fourth_order_difference(along, h)).epsilon(1e-7).margin(1e-9));
}

TEST_CASE("a classifier is read with its weights", "[detect][classifier]") {
  const test::TemporaryFolder folder;
  const std::string cfg = folder.write("some.cfg", classifier), weights = folder.path("some.weights");
  const auto network = random_classifier(classifier).cast<float>();
  io::write_weight_file(weights, network);
  const auto loaded = io::read_classifier<float>(cfg, weights, 32, 24);
  CHECK(loaded.warnings.empty());
  CHECK(loaded.model.input_height() == 32);
  CHECK(loaded.model.parameters() == network.parameters());
  CHECK_THROWS_AS(io::read_darknet_model<float>(cfg, weights), FileError);  // no detector
}

TEST_CASE("a network of dropout alone hands out the picture", "[detect][classifier]") {
  const auto detector = random_classifier("[net]\nwidth=2\nheight=3\n[dropout]\n[dropout]\n").detector();
  const auto images = random_array<double>({1, 3, 2, 3}, 2);
  detect::Pass<double> pass;
  detector.forward(images, pass, detect::Mode::input_gradient);
  CHECK(pass.logits[0](0, 1, 2, 0) == images(0, 2, 0, 1));
  auto adjoint = tapestry::zeros<double, 4>(images.shape());
  detector.input_adjoint(pass, pass.logits, adjoint);
  CHECK((adjoint == images));
}

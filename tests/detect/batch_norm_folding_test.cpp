#include <tapestry/io/darknet/model_file.hpp>

#include "../support/random_array.hpp"
#include "../support/random_model.hpp"
#include "../support/refusal.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
template <class T>
detect::DarknetModel<T> normalised_model() {
  return test::random_model<T>(io::parse_network_config(test::cfg_text("two_heads"), "two heads"), 3);
}
}  // namespace

TEST_CASE("fold_batch_norm of one filter is what is worked out by hand", "[detect][folding]") {
  auto config = io::parse_classifier_config(
      "[net]\nwidth=2\nheight=2\nchannels=3\n[convolutional]\nbatch_normalize=1\nfilters=1\nsize=1\n"
      "activation=linear\n",
      "one filter");
  config.batch_norm_epsilon = 1;
  const auto layout = detect::parameter_layout(config, detect::infer_shapes(config, 2, 2));
  Array<double, 1> parameters(Extents<1>{7});
  const std::vector<double> values{5, 6, 2, 3, 1, 2, 4};  // β, γ, μ, σ², three weights; f = 6 / √(3 + 1) = 3
  std::copy(values.begin(), values.end(), parameters.data());
  const auto folded = detect::fold_batch_norm(config, layout, parameters);
  REQUIRE(folded.size() == 4);
  CHECK(std::vector<double>(folded.begin(), folded.end()) == std::vector<double>{-1, 3, 6, 12});
  auto single = tapestry::cast<float>(parameters);
  single(1) = 3e38F;
  check_refused(ErrorKind::numeric, "layer 0",
                [&] { (void)detect::fold_batch_norm(config, layout, single); });
}

TEST_CASE("the folded model finds what the model finds, but for rounding", "[detect][folding]") {
  const auto model = normalised_model<float>();
  const detect::DarknetModel<float> folded(
      detect::without_batch_norm(model.config()),
      detect::fold_batch_norm(model.config(), model.layout(), model.parameters()));
  const auto images = random_array<float>({2, 8, 8, 3}, 6);
  const auto logits = detect::forward(folded.detector(), images);
  // Not simplified, so that nothing is folded beforehand.
  const auto expected = detect::forward(model.learning_detector(false), images);
  REQUIRE(logits.size() == expected.size());
  for (std::size_t head = 0; head < logits.size(); ++head)
    for (std::size_t i = 0; i < logits[head].size(); ++i)
      CHECK(logits[head].data()[i] == Approx(expected[head].data()[i]).epsilon(1e-5).margin(1e-5));
}

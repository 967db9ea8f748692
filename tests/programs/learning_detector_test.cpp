#include "../../examples/programs/shell/learning_detector.hpp"

#include "../support/catch.hpp"
#include "../support/paths.hpp"

using namespace tapestry;

TEST_CASE("a detector that learns keeps the names of its classes", "[programs]") {
  const std::string assets = test::in_sources("examples/assets/");
  const std::string cfg = assets + "detector.cfg", weights = assets + "detector.weights";
  const std::vector<std::string> names{"car", "van", "clutter"};
  shell::LearningModel learning(io::read_darknet_model<float>(cfg, weights).model,
                                shell::trainable_cfg(cfg, weights), names);
  CHECK(learning.detector().names() == names);
  learning.set_weights(learning.weights() * 0.5F);
  CHECK(learning.detector().names() == names);
}

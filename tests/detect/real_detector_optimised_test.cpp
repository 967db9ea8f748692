#include <tapestry/image/batch.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/read_detector.hpp>

#include "../support/catch.hpp"
#include "../support/paths.hpp"

namespace detect = tapestry::detect;

namespace {
/// Detection of OpenCV's DNN module: confidence, then the box's left, top, width, height in the frame.
struct Expected {
  const char* frame;
  double confidence, x, y, w, h;
};

struct Row {
  const char* detector;
  std::size_t size;
  std::array<Expected, 6> cars;
};

const std::string data = tapestry::test::in_shared("data/");
constexpr std::size_t car = 2;

const std::array<Row, 4> table = {{
    {"yolo-fastest-1.1-xl",
     320,
     {{{"data1", .99, 166, 321, 440, 174},
       {"data12501", .98, 193, 325, 430, 159},
       {"data12502", .93, 271, 284, 242, 294},
       {"data12503", .98, 180, 319, 417, 173},
       {"data12504", .76, 283, 303, 243, 252},
       {"data12505", .98, 206, 311, 336, 223}}}},
    {"yolo-fastest-1.1-xl",
     416,
     {{{"data1", .97, 179, 306, 435, 191},
       {"data12501", .97, 197, 309, 411, 185},
       {"data12502", .83, 272, 306, 249, 267},
       {"data12503", .99, 176, 311, 448, 182},
       {"data12504", .83, 285, 309, 235, 228},
       {"data12505", .97, 226, 298, 303, 238}}}},
    {"mobilenetv2-yolov3-nano",
     320,
     {{{"data1", .94, 177, 320, 416, 171},
       {"data12501", .96, 239, 329, 363, 152},
       {"data12502", .73, 273, 307, 235, 275},
       {"data12503", .95, 187, 322, 380, 164},
       {"data12504", .78, 274, 306, 238, 242},
       {"data12505", .91, 193, 293, 353, 237}}}},
    {"mobilenetv2-yolov3-nano",
     416,
     {{{"data1", .99, 184, 325, 395, 152},
       {"data12501", .97, 196, 325, 416, 151},
       {"data12502", .74, 275, 298, 239, 277},
       {"data12503", .98, 168, 318, 426, 159},
       {"data12504", .82, 289, 326, 230, 219},
       {"data12505", .66, 217, 298, 333, 232}}}},
}};

/// A frame as the network takes it, [1, size, size, 3].
tapestry::Array<float, 4> network_input(const std::string& frame, std::size_t size) {
  const auto picture = tapestry::io::read_frame(data + "carla/" + frame + ".npz").image;
  tapestry::Array<float, 3> colours(picture.shape());
  for (std::size_t i = 0; i < picture.size(); ++i)
    colours.data()[i] = static_cast<float>(picture.data()[i]) / 255;
  return tapestry::image::batch_of(tapestry::image::resize_bilinear(colours, size, size));
}

/// The most confident car, its box in pixels of the frame of 800 × 800.
detect::Detection best_car(const detect::Detector<float>& detector, const std::string& frame) {
  const auto size = detector.input_height();
  const auto logits = detect::forward(detector, network_input(frame, size));
  const auto found = detect::suppress(detect::decode(detector.heads(), logits, 0, 0.25, size, size), 0.45);
  for (detect::Detection detection : found) {
    if (detection.class_index != car) continue;
    const double scale = 800.0 / static_cast<double>(size);
    detection.box = {detection.box.cx * scale, detection.box.cy * scale, detection.box.w * scale,
                     detection.box.h * scale};
    return detection;
  }
  return {};
}
}  // namespace

TEST_CASE("detectors trained on photographs find the car of real frames as OpenCV does", "[detect][real]") {
  if (tapestry::test::is_absent(data + "detectors")) return;
  for (const Row& row : table) {
    const std::string files = data + "detectors/" + row.detector;
    const auto detector = tapestry::io::read_detector<float>(
        {.weights = files + ".weights", .config = files + ".cfg", .size = row.size});
    for (const Expected& expected : row.cars) {
      const auto found = best_car(detector, expected.frame);
      INFO(row.detector << " " << row.size << " " << expected.frame << ": " << found.confidence << " "
                        << found.box.left() << "," << found.box.top() << " " << found.box.w << "x"
                        << found.box.h);
      CHECK(std::abs(found.confidence - expected.confidence) <= 0.02);
      CHECK(std::abs(found.box.left() - expected.x) <= 2);
      CHECK(std::abs(found.box.top() - expected.y) <= 2);
      CHECK(std::abs(found.box.w - expected.w) <= 2);
      CHECK(std::abs(found.box.h - expected.h) <= 2);
    }
  }
}

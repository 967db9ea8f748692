#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/npy.hpp>

#include "../support/paths.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
Array<std::uint8_t, 3> picture(std::size_t height, std::size_t width, std::size_t channels) {
  Array<std::uint8_t, 3> image(Extents<3>{height, width, channels});
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<std::uint8_t>(i);
  return image;
}

/// Members of a frame file, each of which can be replaced.
struct Members {
  Array<std::uint8_t, 3> img = picture(2, 3, 3);
  Array<double, 2> veh_trans = {{1, 2, 0.6}, {0, 90, 0}}, cam_trans = {{3, 4, 5}, {-45, -126.9, 0}};

  [[nodiscard]] io::NpzWriter writer() const {
    io::NpzWriter result;
    result.add("img", img);
    result.add("veh_trans", veh_trans);
    result.add("cam_trans", cam_trans);
    return result;
  }
};

/// Compares all parts that have bits of their own.
void check_same(const io::Frame& found, const io::Frame& expected) {
  CHECK((found.image == expected.image));
  REQUIRE((found.mask && found.light && found.label && found.camera));
  CHECK((*found.mask == *expected.mask));
  CHECK(found.light->ambient == expected.light->ambient);
  CHECK(found.light->direction == expected.light->direction);
  CHECK(found.light->colour == expected.light->colour);
  CHECK(found.label->class_index == expected.label->class_index);
  CHECK(found.label->box.cx == expected.label->box.cx);
  CHECK(found.label->box.h == expected.label->box.h);
  CHECK(found.camera->rotation == expected.camera->rotation);
  CHECK(found.camera->translation == expected.camera->translation);
  CHECK(found.camera->tan_half_fov_x == expected.camera->tan_half_fov_x);
  CHECK(found.camera->tan_half_fov_y == expected.camera->tan_half_fov_y);
}

/// A camera that is turned about the vertical axis by the 3-4-5 angle.
void add_camera(io::NpzWriter& writer, double scale = 1, double fov = 1) {
  const Array<double, 2> matrix = {{0.6 * scale, 0.8, 0, 1}, {-0.8, 0.6, 0, 2}, {0, 0, 1, 3}};
  writer.add("camera_matrix", matrix);
  writer.add("camera_fov", std::vector<double>{fov, 0.5});
}

const test::TemporaryFolder folder;

io::Frame read(const io::NpzWriter& writer) {
  writer.write(folder.path("frame.npz"));
  return io::read_frame(folder.path("frame.npz"));
}
}  // namespace

TEST_CASE("a CARLA frame is read with its channels swapped once", "[io][frame]") {
  const io::Frame frame = read(Members{}.writer());
  CHECK(frame.image(0, 0, 0) == 2);
  CHECK(frame.image(0, 0, 2) == 0);
  CHECK(frame.image(1, 2, 0) == 17);
  CHECK(frame.pose == geometry::CarlaPose{{1, 2, 0.6}, {0, 90, 0}, {3, 4, 5}, {-45, -126.9, 0}});
  CHECK(frame.warnings.empty());
  CHECK_FALSE((frame.camera || frame.light || frame.mask || frame.label));
}

TEST_CASE("a frame of our own comes back", "[io][frame]") {
  io::NpzWriter writer;
  writer.add("img", picture(2, 3, 3));
  add_camera(writer);
  io::Frame frame = read(writer);
  REQUIRE(frame.camera);
  CHECK(frame.camera->rotation[1] == std::array<double, 3>{-0.8, 0.6, 0});
  CHECK(frame.camera->translation == std::array<double, 3>{1, 2, 3});
  frame.light = raster::Light{0.5, 0.25, {0, 0, 1}, {1, 0.9, 0.8}};
  frame.mask = Array<std::uint8_t, 2>{{0, 255, 0}, {1, 2, 3}};
  frame.label = io::Label{1, {1.5, 0.5, 3, 0.25}};
  io::write_frame(folder.path("again.npz"), frame);
  CHECK(frame.camera->tan_half_fov_x == 1);
  CHECK(frame.camera->tan_half_fov_y == 0.5);
  check_same(io::read_frame(folder.path("again.npz")), frame);
  CHECK(io::frame_paths(folder.path()).size() >= 1);
  frame.image = picture(2, 3, 4);
  CHECK_THROWS_AS(io::write_frame(folder.path("again.npz"), frame), ShapeError);
}

TEST_CASE("a frame in three parts comes back", "[io][frame]") {
  const test::TemporaryFolder own;
  io::Frame frame;
  frame.image = picture(2, 3, 3);
  frame.camera = geometry::orbit_camera(0.3, 0.2, 7, {0, 0, 0.7}, 1);
  frame.light = raster::Light{0.5, 0.25, {0, 0, 1}, {1, 0.9, 0.8}};
  frame.mask = Array<std::uint8_t, 2>{{0, 255, 0}, {1, 2, 3}};
  frame.label = io::Label{1, {1.5, 0.5, 3, 0.25}};
  io::write_frame(own.path("10.json"), frame);
  io::write_frame(own.path("10.npz"), frame);
  const io::Frame again = io::read_frame(own.path("10.json"));
  check_same(again, io::read_frame(own.path("10.npz")));
  CHECK((again.image == frame.image));
  CHECK_FALSE(again.pose.has_value());
  CHECK((io::read_picture(own.path("10.json")) == frame.image));
  CHECK(io::frame_files(own.path("10.json")) ==
        std::vector{own.path("10.json"), own.path("10.png"), own.path("masks/10.png")});
  CHECK(io::frame_files(own.path("10.npz")) == std::vector{own.path("10.npz")});
  CHECK(io::frame_paths(own.path()) == std::vector{own.path("10.npz")});  // which come first
  std::filesystem::remove(own.path("10.npz"));
  std::filesystem::remove(own.path("masks/10.png"));
  frame.camera.reset();
  frame.mask.reset();
  frame.pose = geometry::CarlaPose{{1, 2, 0.6}, {0, 90, 0}, {3, 4, 5}, {-45, -126.9, 0}};
  io::write_frame(own.path("9.json"), frame);
  CHECK(io::frame_paths(own.path()) == std::vector{own.path("9.json"), own.path("10.json")});
  CHECK(io::read_frame(own.path("9.json")).pose == frame.pose);
  CHECK_FALSE(io::read_frame(own.path("9.json")).mask.has_value());
}

TEST_CASE("each part of a frame that is missing or malformed is refused by name", "[io][frame][bad_input]") {
  const test::TemporaryFolder own;
  const std::string path = own.path("a.json");
  const std::string pose = R"("veh_trans": [[0, 0, 0], [0, 0, 0]], "cam_trans": [[5, 0, 2], [-10, 180, 0]])";
  const auto refused = [&](ErrorKind kind, const std::string& members, const std::string& text) {
    own.write("a.json", R"({"format": "tapestry frame 1")" + (members.empty() ? "" : ", " + members) + "}");
    check_refused(kind, text, [&] { (void)io::read_frame(path); });
  };
  refused(ErrorKind::mismatch, pose, "a.json: no picture beside the frame; expected " + own.path("a.png"));
  io::write_image(own.path("a.png"), picture(4, 6, 3));
  CHECK(io::read_frame(path).image.shape(1) == 6);
  refused(ErrorKind::mismatch, "", "member 'veh_trans' is missing; expected veh_trans, found none");
  refused(ErrorKind::mismatch, R"("camera_fov": [1, 1])", "member 'camera_matrix' is missing");
  refused(ErrorKind::mismatch, pose + R"(, "lens": [1])",
          "a.json: unknown member 'lens'; expected camera_matrix");
  for (const char* light : {"[]", "{}", "1", R"(["bright"])", "[[1, 2], [3]]", "[[1, 2], 3]"})
    refused(ErrorKind::mismatch, pose + R"(, "light": )" + light, "member 'light' is no list of numbers");
  refused(ErrorKind::mismatch, pose + R"(, "light": [1, 2])",
          "'light' has another shape; expected (8,), found (2,)");
  for (const char* light :
       {"[1e300, 0, 0, 0, 1, 1, 1, 1]", "[0, -1e10, 0, 0, 1, 1, 1, 1]", "[0.5, 0.5, 0, 0, 1, 1, 1, 1e308]"})
    refused(ErrorKind::mismatch, pose + R"(, "light": )" + light,
            "a.json: member 'light' is too bright; expected numbers of at most 1e9");
  refused(ErrorKind::mismatch, pose + R"(, "light": [0.5, 0.5, 0, 0, 0, 1, 1, 1])",
          "a.json: member 'light' has no direction");
  own.write("a.json", "{" + pose + "}");
  check_refused(ErrorKind::malformed, "a.json: is not the JSON of a frame; expected a member format",
                [&] { (void)io::read_frame(path); });
  own.write("a.json", "[");
  check_refused(ErrorKind::malformed, "a.json", [&] { (void)io::read_frame(path); });
  check_refused(ErrorKind::malformed, "b.json", [&] { (void)io::read_frame(own.path("b.json")); });
  own.write("a.json", R"({"format": "tapestry frame 1", )" + pose + "}");
  std::filesystem::create_directory(own.path("masks"));
  io::write_mask(own.path("masks/a.png"), Array<float, 2>{{0, 1}});
  check_refused(ErrorKind::mismatch, "mask of another size than " + own.path("a.png"),
                [&] { (void)io::read_frame(path); });
  own.write("masks/a.png", "no picture");
  check_refused(ErrorKind::malformed, own.path("masks/a.png"), [&] { (void)io::read_frame(path); });
  std::filesystem::remove(own.path("masks/a.png"));
  own.write("a.png", "no picture");
  check_refused(ErrorKind::malformed, "a.png", [&] { (void)io::read_frame(path); });  // N28
}

TEST_CASE("frames that cannot be are refused", "[io][frame][bad_input]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Row {
    const char* id;
    io::NpzWriter writer;
    const char* text;
  };
  const auto extended = [](auto add) {
    auto writer = Members{}.writer();
    add(writer);
    return writer;
  };
  io::NpzWriter no_camera_pose, float_image, flat_image;
  no_camera_pose.add("img", picture(2, 3, 3));
  no_camera_pose.add("veh_trans", Members{}.veh_trans);
  float_image.add("img", Array<float, 3>(Extents<3>{1, 1, 3}, 0.0F));
  flat_image.add("img", Array<std::uint8_t, 2>{{1, 2, 3}});
  using Numbers = std::vector<double>;
  const auto labelled = [&](const Numbers& label) {
    return extended([&](auto& to) { to.add("label", label); });
  };
  const Row rows[] = {
      {"N12", no_camera_pose, "'cam_trans' is missing; expected cam_trans, found img, veh_trans"},
      {"N12 shape", Members{.cam_trans = {{1, 2}, {3, 4}, {5, 6}}}.writer(), "expected (2, 3), found (3, 2)"},
      {"N13 channels", Members{.img = picture(2, 2, 4)}.writer(), "found u1 (2, 2, 4)"},
      {"N13 empty", Members{.img = picture(0, 2, 3)}.writer(), "found u1 (0, 2, 3)"},
      {"N13 type", float_image, "found f4 (1, 1, 3)"},
      {"N13 axes", flat_image, "found u1 (1, 3)"},
      {"N14 NaN", Members{.veh_trans = {{0, 0, nan}, {0, 0, 0}}}.writer(),
       "veh_trans holds a value that is not"},
      {"N14 distance", Members{.cam_trans = {{0, 0, 0}, {0, 0, 0}}}.writer(), "distance 0"},
      {"I13", extended([](auto& to) {
         to.add("mask", Array<std::uint8_t, 2>{{1, 2}});
       }),
       "found (1, 2)"},
      {"N19 columns", labelled(Numbers(4, 0.5)), "expected (5,), found (4,)"},
      {"N19 width", labelled({1, .5, .5, 0, .5}), "no box"},
      {"N19 pixels", labelled({1, 50, .5, .5, .5}), "no box"},
      {"N19 huge class", labelled({1e300, .5, .5, .5, .5}), "no box"},
      {"N19 class", labelled({-1, .5, .5, .5, .5}), "no box"},
      {"camera scaled", extended([](auto& to) { add_camera(to, 1.1); }), "no rotation"},
      {"camera fov", extended([](auto& to) { add_camera(to, 1, 0); }), "no field of view"},
      {"light", extended([](auto& to) { to.add("light", Numbers(3, 1.0)); }), "expected (8,)"},
      {"camera half", extended([](auto& to) { to.add("camera_fov", Numbers(2, 1.0)); }),
       "'camera_matrix' is missing"},
  };
  for (const Row& row : rows) {
    INFO(row.id);
    check_refused(ErrorKind::mismatch, row.text, [&] { (void)read(row.writer); });
    check_refused(ErrorKind::mismatch, "frame.npz:", [&] { (void)read(row.writer); });
  }
}

TEST_CASE("odd poses are noticed", "[io][frame]") {  // N14
  const auto warning = [](const Array<double, 2>& pose) {
    const auto warnings = read(Members{.cam_trans = pose}.writer()).warnings;
    return warnings.empty() ? std::string("none") : warnings.back();
  };
  CHECK_THAT(warning({{3, 4, 5}, {-0.7854, -2.2143, 0}}), contains("look like radians"));
  CHECK_THAT(warning({{3, 4, 5}, {-45, 90, 0}}), contains("past the vehicle"));
  CHECK_THAT(warning({{0, 0, 5}, {-90, 0, 0}}), contains("straight"));
  CHECK_THAT(warning({{1, 0, 0}, {0, 180, 0}}), contains("inside"));
}

TEST_CASE("a folder without frames is refused", "[io][frame]") {
  const test::TemporaryFolder empty;
  check_refused(ErrorKind::mismatch, "holds no frame", [&] { (void)io::frame_paths(empty.path()); });
  check_refused(ErrorKind::malformed, "cannot list", [&] { (void)io::frame_paths(empty.path("absent")); });
}

TEST_CASE("frames are listed by the numbers in their names", "[io][frame]") {
  const test::TemporaryFolder unsorted;
  for (const char* name : {"data10.npz", "data9.npz", "data010.npz", "a2b1.npz", "a2b.npz", "a12b.npz",
                           "data.npz", "data1.txt", "12345678901234567890123.npz"})
    std::ofstream(unsorted.path(name)) << "frame";
  std::vector<std::string> names;
  for (const auto& path : io::frame_paths(unsorted.path()))
    names.push_back(std::filesystem::path(path).stem().string());
  CHECK(names == std::vector<std::string>{"12345678901234567890123", "a2b", "a2b1", "a12b", "data", "data9",
                                          "data010", "data10"});
}

TEST_CASE("the real frames are read without a warning", "[io][frame]") {
  const std::string real = test::in_shared("data/carla");
  if (is_absent(real)) return;
  const auto paths = io::frame_paths(real);
  CHECK(paths.size() == 6);
  const io::Frame frame = io::read_frame(paths[0]);
  CHECK(frame.warnings.empty());
  CHECK((frame.image.shape() == Extents<3>{800, 800, 3}));
  double red = 0, blue = 0;  // the car in the middle is blue
  for (std::size_t row = 380; row < 420; ++row) {
    for (std::size_t column = 300; column < 500; ++column) {
      red += frame.image(row, column, 0);
      blue += frame.image(row, column, 2);
    }
  }
  CHECK(blue > red);
}

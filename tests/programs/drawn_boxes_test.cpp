#include <set>

#include "../../examples/programs/shell/picture_sheet.hpp"
#include "../support/catch.hpp"

using namespace tapestry;
using shell::Bitmap, shell::Colour;

namespace {
constexpr Colour black{0, 0, 0}, white{255, 255, 255};

Bitmap blank(std::size_t height, std::size_t width) {
  return tapestry::filled<std::uint8_t, 3>({height, width, 3}, std::uint8_t(255));
}

Colour pixel(const Bitmap& bitmap, std::size_t y, std::size_t x) {
  return {bitmap(y, x, 0), bitmap(y, x, 1), bitmap(y, x, 2)};
}

std::size_t count_of(const Bitmap& bitmap, const Colour& colour) {
  std::size_t count = 0;
  for (std::size_t y = 0; y < bitmap.shape(0); ++y)
    for (std::size_t x = 0; x < bitmap.shape(1); ++x) count += pixel(bitmap, y, x) == colour ? 1 : 0;
  return count;
}

double linear(std::uint8_t level) {
  const double share = level / 255.0;
  return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

double luminance(const Colour& c) {
  return 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
}

/// CIE L*a*b* of sRGB under D65.
std::array<double, 3> lab(const Colour& c) {
  const double r = linear(c[0]), g = linear(c[1]), b = linear(c[2]);
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505), y = f(luminance(c));
  const double z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double difference(const Colour& a, const Colour& b) {
  const auto p = lab(a), q = lab(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}
}  // namespace

TEST_CASE("glyphs are rows of five pixels, each its own", "[programs][font]") {
  std::set<std::string_view> seen;
  for (const auto rows : shell::detail::glyphs) {
    CHECK(seen.insert(rows).second);
    CHECK((rows.empty() || rows.size() % 6 == 5));
    CHECK(rows.size() <= 6 * shell::glyph_height);
    for (std::size_t i = 0; i < rows.size(); ++i)
      CHECK((i % 6 == 5 ? rows[i] == ' ' : rows[i] == '.' || rows[i] == '#'));
  }
}

TEST_CASE("text is drawn as wide as it says, whatever it holds", "[programs][font]") {
  CHECK(shell::text_width("", 3) == 0);
  CHECK(shell::text_width("car", 2) == 2 * 17);
  CHECK(shell::text_width("\xc3\xa9", 1) == 5);  // one character of two bytes
  for (const long scale : {1L, 3L}) {
    auto bitmap = blank(40, 80);
    shell::draw_text(bitmap, 4, 5, "I", scale, black);
    CHECK(count_of(bitmap, black) == static_cast<std::size_t>(11 * scale * scale));
    CHECK(pixel(bitmap, 5, static_cast<std::size_t>(4 + scale)) == black);  // the serif's left end
  }
  auto boxes = blank(12, 14), control = boxes;
  shell::draw_text(boxes, 1, 1, "\xc3\xa9\xc3\xa9", 1, black);
  shell::draw_text(control, 1, 1, "\x1b\x7f", 1, black);
  CHECK(count_of(boxes, black) == 2 * 20);
  CHECK(std::equal(boxes.begin(), boxes.end(), control.begin()));
}

TEST_CASE("text beyond the picture is cut", "[programs][font]") {
  auto bitmap = blank(6, 6);
  shell::draw_text(bitmap, -8, -3, "##", 4, black);
  shell::draw_text(bitmap, 100, 100, "W", 1, black);
  CHECK(count_of(bitmap, black) > 0);
}

TEST_CASE("colours of classes are told apart, and text on them is read", "[programs][boxes]") {
  // CIE 1976: differences of 2.3 are just noticeable side by side. Text: WCAG 2.1 asks for a contrast of 4.5.
  for (std::size_t a = 0; a < 80; ++a) {
    const Colour colour = shell::class_colour(a);
    CHECK(shell::class_colour(a) == colour);
    for (std::size_t b = 0; b < a; ++b) {
      CAPTURE(a, b);
      CHECK(difference(colour, shell::class_colour(b)) > (a < 12 ? 30 : 4));
    }
    CHECK(difference(colour, shell::found_colour) > 25);
    const double ground = luminance(colour), text = luminance(shell::text_colour_on(colour));
    CHECK((std::max(ground, text) + 0.05) / (std::min(ground, text) + 0.05) >= 4.5);
  }
  CHECK(shell::text_colour_on(white) == black);
  CHECK(shell::text_colour_on(black) == white);
}

TEST_CASE("a label stands on its box in the colour of the box", "[programs][boxes]") {
  const Colour colour{240, 200, 60};  // with black text
  for (const std::size_t side : {320U, 1200U}) {
    auto bitmap = blank(side, side);
    const auto middle = static_cast<double>(side) / 2;
    shell::draw_boxes(bitmap, {{{middle, middle, middle, middle}, "car 0.93", colour}});
    const long scale = side == 320 ? 1 : 3;
    const auto left = side / 4, top = side / 4;
    CHECK(pixel(bitmap, top, left) == colour);
    CHECK(pixel(bitmap, top - static_cast<std::size_t>(scale), left) == colour);
    CHECK(pixel(bitmap, side / 2, side / 2) == white);  // nothing is drawn within the box
    auto text = blank(static_cast<std::size_t>(9 * scale), 200);
    shell::draw_text(text, 0, 0, "car 0.93", scale, black);
    CHECK(count_of(bitmap, black) == count_of(text, black));
  }
}

TEST_CASE("labels stay in the picture and clear of each other", "[programs][boxes]") {
  const auto bitmap = blank(100, 200);
  std::vector<shell::detail::PixelRectangle> taken;
  const std::vector<detect::Box> boxes{{30, 50, 40, 40}, {30, 50, 40, 40},  {30, 50, 40, 40},
                                       {190, 5, 40, 40}, {100, 98, 20, 30}, {-50, 50, 20, 20}};
  for (const auto& box : boxes) {
    const auto at = shell::detail::label_place(shell::detail::pixels_of(box, bitmap), 60, 11, bitmap, taken);
    CHECK((at.left >= 0 && at.top >= 0 && at.right <= 200 && at.bottom <= 100));
    for (const auto& other : taken) CHECK_FALSE(at.meets(other));
    taken.push_back(at);
  }
}

TEST_CASE("boxes are cut at the edge of the picture, where they are still seen", "[programs][boxes]") {
  auto bitmap = blank(50, 50);
  const Colour colour{200, 30, 60};
  shell::draw_boxes(bitmap, {{{25, 25, 400, 400}, "", colour}});
  for (const std::size_t i : {0U, 20U, 49U}) {
    CHECK(pixel(bitmap, i, 0) == colour);
    CHECK(pixel(bitmap, 49, i) == colour);
  }
  CHECK(pixel(bitmap, 25, 25) == white);
}

TEST_CASE("the surer of two boxes lies on top", "[programs][boxes]") {
  auto bitmap = blank(50, 50);
  const Colour first{200, 30, 60}, second{20, 30, 160};
  shell::draw_boxes(bitmap, {{{25, 25, 20, 20}, "", first}, {{25, 25, 20, 20}, "", second}});
  CHECK(count_of(bitmap, second) == 0);
  CHECK(count_of(bitmap, first) > 0);
}

TEST_CASE("pictures shrink with their boxes", "[programs][boxes]") {
  const shell::MarkedPicture marked{blank(400, 900), {{{450, 200, 90, 40}, "car", black}}};
  const auto half = shell::halved(marked);
  CHECK(half.picture.shape(0) == 200);
  CHECK(half.boxes.front().box.w == 45);
  const auto small = shell::fitted_within(marked, 300);
  CHECK(small.picture.shape(1) == 300);
  CHECK(small.picture.shape(0) == 133);  // 400 / 3
  CHECK(std::abs(small.boxes.front().box.cx - 150) < 1e-9);
  CHECK(std::abs(small.boxes.front().box.cy - 66.5) < 1e-9);
  CHECK(shell::fitted_within(marked, 900).picture.shape(0) == 400);
}

TEST_CASE("a sheet shows evenly spread pictures under their names", "[programs][sheet]") {
  shell::PictureSheet sheet(400);
  std::size_t shown = 0;
  for (std::size_t i = 0; i < 400; ++i) shown += sheet.shows(i) ? 1 : 0;
  CHECK(shown == 160);
  CHECK(sheet.side() == 320);
  CHECK_FALSE(shell::PictureSheet(0).shows(0));
  shell::PictureSheet two(2);
  CHECK((two.shows(0) && two.shows(1)));
  two.add("first.png", {blank(30, 60), {}});
  two.add("second.png", {blank(60, 30), {}});
  const auto bitmap = two.bitmap();
  CHECK(bitmap.shape(0) == 4 + 13 + 60 + 4);
  CHECK(bitmap.shape(1) == 2 * 60 + 12);
  CHECK(count_of(bitmap, black) > 50);  // names
  shell::PictureSheet rows(4);
  for (const std::size_t height : {10U, 20U, 30U, 40U}) rows.add("", {blank(height, 8), {}});
  CHECK(rows.bitmap().shape(0) == 4 + (13 + 30 + 4) + (13 + 40 + 4));  // three columns
}

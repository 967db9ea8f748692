#pragma once
#include <charconv>
#include <tapestry/io/image_file.hpp>
#include "pixel_font.hpp"

/// \file
/// A writer of PDF 1.4 (ISO 32000-1): pages with lines, areas, text in Helvetica and pictures. Libraries of
/// our distributions are much larger than this needs. Equal pages give equal bytes.

namespace tapestry::shell {
inline constexpr double pt_per_cm = 72 / 2.54;

/// A point of a page in centimetres, from its lower left corner.
using PagePoint = std::array<double, 2>;

/// An upright rectangle, centimetres.
struct PageBox {
  double left = 0, bottom = 0, width = 0, height = 0;
};

/// One page that is drawn from the back to the front.
class PdfPage {
 public:
  /// \param width, height  centimetres
  PdfPage(double width, double height) : box_{0, 0, width, height} {}

  [[nodiscard]] const PageBox& box() const { return box_; }
  [[nodiscard]] const std::string& content() const { return content_; }
  [[nodiscard]] const std::vector<std::size_t>& pictures() const { return pictures_; }

  void line(const PagePoint& from, const PagePoint& to, double width_pt = 0.5) {
    content_ += number(width_pt) + " w " + point(from) + "m " + point(to) + "l S\n";
  }

  /// \param colour  RGB in [0, 1]
  void area(const PageBox& box, const std::array<double, 3>& colour) {
    content_ += "q " + number(colour[0]) + ' ' + number(colour[1]) + ' ' + number(colour[2]) + " rg " +
                rectangle(box) + "f Q\n";
  }

  /// \param text one line; other than printable ASCII becomes a question mark
  void text(const PagePoint& baseline, double size_pt, std::string_view text) {
    content_ += "BT /F1 " + number(size_pt) + " Tf " + point(baseline) + "Td (";
    for (const char c : text) {
      if (c == '(' || c == ')' || c == '\\') content_ += '\\';
      content_ += c >= ' ' && c <= '~' ? c : '?';
    }
    content_ += ") Tj ET\n";
  }

  /// Clips later drawing to a box, until end_clip().
  void begin_clip(const PageBox& box) { content_ += "q " + rectangle(box) + "W n\n"; }

  /// Clips later drawing to the union of some triangles, at least one, until end_clip().
  void begin_clip(const std::vector<std::array<PagePoint, 3>>& triangles) {
    content_ += "q\n";
    for (const auto& [a, b, c] : triangles) {  // all turn left, so that overlaps do not cancel
      const bool is_left = (b[0] - a[0]) * (c[1] - a[1]) >= (b[1] - a[1]) * (c[0] - a[0]);
      content_ += point(a) + "m " + point(is_left ? b : c) + "l " + point(is_left ? c : b) + "l h\n";
    }
    content_ += "W n\n";
  }

  void end_clip() { content_ += "Q\n"; }

  /// \param picture  as PdfFile::add_picture() returned it
  void picture(const PageBox& box, std::size_t picture) {
    content_ += "q " + length(box.width) + "0 0 " + length(box.height) + point({box.left, box.bottom}) +
                "cm /P" + std::to_string(picture) + " Do Q\n";
    pictures_.push_back(picture);
  }

 private:
  friend class PdfFile;

  /// To a thousandth, in any locale.
  static std::string number(double value) {
    std::array<char, 64> text{};
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 3).ptr;
    return {text.data(), end};
  }
  static std::string length(double cm) { return number(cm * pt_per_cm) + ' '; }
  static std::string point(const PagePoint& cm) { return length(cm[0]) + length(cm[1]); }
  static std::string rectangle(const PageBox& box) {
    return point({box.left, box.bottom}) + length(box.width) + length(box.height) + "re ";
  }

  PageBox box_;
  std::string content_;
  std::vector<std::size_t> pictures_;
};

class PdfFile {
 public:
  /// \param path  for messages
  /// \returns     the picture's number for PdfPage::picture()
  std::size_t add_picture(const std::string& path, const Bitmap& bitmap) {
    constexpr int quality = 95;  // of colours at full resolution, see jpeg_file()
    pictures_.push_back(
        stream("/Type /XObject /Subtype /Image /ColorSpace /DeviceRGB /BitsPerComponent 8 /Filter /DCTDecode "
               "/Width " +
                   std::to_string(bitmap.shape(1)) + " /Height " + std::to_string(bitmap.shape(0)),
               io::jpeg_file(path, bitmap, quality)));
    return pictures_.size() - 1;
  }

  void add(PdfPage page) { pages_.push_back(std::move(page)); }

  [[nodiscard]] std::string bytes() const {
    const std::size_t first_page = 4 + pictures_.size();  // after the catalogue, the list of pages, the font
    std::string kids;
    for (std::size_t i = 0; i < pages_.size(); ++i) kids += reference(first_page + 2 * i);
    std::vector<std::string> objects{
        "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        "<< /Type /Pages /Count " + std::to_string(pages_.size()) + " /Kids [ " + kids + "] >>",
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
    objects.insert(objects.end(), pictures_.begin(), pictures_.end());
    for (const PdfPage& page : pages_) {
      std::string used;
      for (const std::size_t picture : page.pictures())
        used += "/P" + std::to_string(picture) + ' ' + reference(4 + picture);
      objects.push_back("<< /Type /Page /Parent 2 0 R /MediaBox [ 0 0 " + PdfPage::length(page.box().width) +
                        PdfPage::length(page.box().height) + "] /Resources << /Font << /F1 3 0 R >> " +
                        "/XObject << " + used + ">> >> /Contents " + reference(objects.size() + 2) + ">>");
      objects.push_back(stream("", page.content()));
    }
    return joined(objects);
  }

 private:
  static std::string reference(std::size_t object) { return std::to_string(object) + " 0 R "; }

  static std::string stream(const std::string& keys, const std::string& bytes) {
    return "<< " + keys + " /Length " + std::to_string(bytes.size()) + " >>\nstream\n" + bytes +
           "\nendstream";
  }

  /// The objects, numbered from 1, and the table of their places in the file.
  static std::string joined(const std::vector<std::string>& objects) {
    std::string file = "%PDF-1.4\n%\xE2\xE3\xCF\xD3\n";
    std::string table = "0000000000 65535 f \n";
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const std::string place = std::to_string(file.size());
      table += std::string(10 - place.size(), '0') + place + " 00000 n \n";
      file += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
    }
    const std::string count = std::to_string(objects.size() + 1);
    const std::string start = std::to_string(file.size());
    return file + "xref\n0 " + count + '\n' + table + "trailer\n<< /Size " + count +
           " /Root 1 0 R >>\nstartxref\n" + start + "\n%%EOF\n";
  }

  std::vector<std::string> pictures_;
  std::vector<PdfPage> pages_;
};
}  // namespace tapestry::shell

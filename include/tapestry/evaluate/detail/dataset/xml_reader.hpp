#pragma once
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <vector>

namespace tapestry::evaluate {
/// An element: its name, text and elements.
struct XmlElement {
  std::string name{};
  std::string text{};  ///< text of the element itself, without blanks around it
  std::size_t line = 0;
  std::vector<XmlElement> children{};

  /// The only child with that name, else null; `count` receives the number of such children.
  [[nodiscard]] const XmlElement* child(std::string_view wanted, std::size_t* count = nullptr) const {
    const XmlElement* found = nullptr;
    std::size_t matches = 0;
    for (const XmlElement& each : children) {
      if (each.name != wanted) continue;
      found = &each;
      ++matches;
    }
    if (count != nullptr) *count = matches;
    return matches == 1 ? found : nullptr;
  }
};

namespace detail {
/// Reads the part of XML that labels use: elements, text, the five named entities, comments and the
/// declaration. Attributes are skipped.
class XmlReader {
 public:
  XmlReader(std::string_view text, const std::string& path) : text_(text), path_(path) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  [[nodiscard]] XmlElement read() {
    skip_blanks();
    if (rest().starts_with("<?xml")) skip_past("?>", "the declaration");
    skip_blanks_and_comments();
    XmlElement root;
    read_element(root, 1);
    skip_blanks_and_comments();
    if (at_ < text_.size()) fail("text behind the outermost element", "the end", next_text());
    return root;
  }

 private:
  static constexpr std::size_t deepest = 16;

  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "") const {
    throw malformed_file({path_, std::to_string(line_), what, expected, found});
  }

  [[nodiscard]] std::string_view rest() const { return text_.substr(at_); }
  [[nodiscard]] std::string next_text() const {
    return at_ < text_.size() ? in_quotes(rest().substr(0, 20)) : std::string("the end");
  }

  void advance(std::size_t count) {
    for (const char c : text_.substr(at_, count)) {
      if (c == '\n') ++line_;
      if (c == '\0') fail("zero byte in XML");
    }
    at_ += count;
  }
  void skip_past(std::string_view end, const std::string& of) {
    const std::size_t found = rest().find(end);
    if (found == std::string_view::npos) fail("XML ends early", std::string(end) + " of " + of, "the end");
    advance(found + end.size());
  }
  void skip_blanks() {
    const std::size_t first = rest().find_first_not_of(" \t\r\n");
    advance(first == std::string_view::npos ? rest().size() : first);
  }
  void skip_blanks_and_comments() {
    for (skip_blanks(); rest().starts_with("<!--"); skip_blanks()) skip_past("-->", "a comment");
  }
  void take(std::string_view wanted) {
    if (!rest().starts_with(wanted)) fail("not the XML of labels", in_quotes(wanted), next_text());
    advance(wanted.size());
  }

  [[nodiscard]] std::string take_name() {
    const std::size_t end = rest().find_first_of(" \t\r\n/>=<&\"'!?");
    const std::string name(rest().substr(0, end));
    if (name.empty()) fail("not the XML of labels", "a name", next_text());
    advance(name.size());
    return name;
  }

  void skip_attributes() {
    for (skip_blanks(); at_ < text_.size() && rest()[0] != '>' && rest()[0] != '/'; skip_blanks()) {
      (void)take_name();
      skip_blanks();
      take("=");
      skip_blanks();
      const std::string_view quote = rest().substr(0, 1);
      if (quote != "\"" && quote != "'") fail("attribute without quotes", "\" or '", next_text());
      advance(1);
      skip_past(quote, "an attribute");
    }
  }

  void read_element(XmlElement& element, std::size_t depth) {
    if (depth > deepest)
      fail("XML nested too deep", "at most " + std::to_string(deepest) + " levels", "more");
    element.line = line_;
    take("<");
    element.name = take_name();
    skip_attributes();
    const bool is_empty = rest().starts_with("/>");
    take(is_empty ? "/>" : ">");
    if (is_empty) return;
    while (!rest().starts_with("</")) {
      if (at_ == text_.size()) fail("XML ends early", "</" + printable(element.name) + ">", "the end");
      if (rest().starts_with("<!--"))
        skip_past("-->", "a comment");
      else if (rest()[0] == '<')
        read_element(element.children.emplace_back(), depth + 1);
      else
        read_text(element.text);
    }
    advance(2);
    const std::string end = take_name();
    if (end != element.name)
      fail("element is closed by another", "</" + printable(element.name) + ">", in_quotes("</" + end + ">"));
    skip_blanks();
    take(">");
    trim(element.text);
  }

  void read_text(std::string& text) {
    while (at_ < text_.size() && rest()[0] != '<') {
      if (rest()[0] == '&') {
        text += take_entity();
        continue;
      }
      const std::string_view plain = rest().substr(0, rest().find_first_of("<&"));
      text += plain;
      advance(plain.size());
    }
  }

  [[nodiscard]] char take_entity() {
    constexpr std::pair<std::string_view, char> entities[] = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
    for (const auto& [name, character] : entities)
      if (rest().starts_with(name)) {
        advance(name.size());
        return character;
      }
    fail("unknown entity", "&amp; &lt; &gt; &quot; or &apos;", next_text());
  }

  static void trim(std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string::npos)
      text.clear();
    else
      text = text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_ = 0, line_ = 1;
};
}  // namespace detail

/// Reads the XML of picture labels, a part of XML: elements of up to 16 levels, text with the five named
/// entities, comments and the declaration. Attributes are skipped. Document types, CDATA sections, processing
/// instructions and other entities are refused, so that nothing is fetched or expanded.
///
/// \param path  the file's name, for messages
/// \throws FileError  malformed, with the line
[[nodiscard]] inline XmlElement parse_xml(std::string_view text, const std::string& path) {
  return detail::XmlReader(text, path).read();
}
}  // namespace tapestry::evaluate

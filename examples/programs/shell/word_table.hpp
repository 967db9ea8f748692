#pragma once
#include <cctype>
#include "protocol/drawing.hpp"

namespace tapestry::shell {
/// A table of words, to be shown as text, Markdown or HTML. Its first column is aligned left, the others
/// right.
struct WordTable {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows{};
};

inline std::string text_of(const WordTable& table) {
  std::vector<std::size_t> widths(table.header.size());
  const auto widen = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  };
  widen(table.header);
  for (const auto& row : table.rows) widen(row);
  std::string text = table.title + "\n";
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size(), ' ');
      text += "  " + (i == 0 ? row[i] + space : space + row[i]);
    }
    text += "\n";
  };
  add(table.header);
  for (const auto& row : table.rows) add(row);
  return text;
}

/// Text for Markdown, a line of plain words: escapes HTML, emphasis, links, code and the end of a table's
/// cell. Brackets alone stay, and underscores within words. Source: CommonMark 0.31, sections 2.4 and 6;
/// GitHub Flavored Markdown 0.29, section 4.10.
inline std::string markdown_escaped(const std::string& text) {
  const auto is_wordlike = [&](std::size_t i) {
    return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0;
  };
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], next = i + 1 < text.size() ? text[i + 1] : ' ';
    const bool is_marked = std::string_view("\\`*|~").find(c) != std::string_view::npos ||
                           (c == ']' && std::string_view("([:").find(next) != std::string_view::npos) ||
                           (c == '_' && !(i > 0 && is_wordlike(i - 1) && is_wordlike(i + 1)));
    out += c == '<'                 ? "&lt;"
           : c == '>'               ? "&gt;"
           : c == '&'               ? "&amp;"
           : c == '\n' || c == '\r' ? " "
           : is_marked              ? std::string{'\\', c}
                                    : std::string(1, c);
  }
  return out;
}

inline std::string markdown_of(const WordTable& table) {
  std::string text = "**" + markdown_escaped(table.title) + "**\n\n";
  const auto add = [&](const std::vector<std::string>& row) {
    for (const auto& word : row) text += "| " + markdown_escaped(word) + " ";
    text += "|\n";
  };
  add(table.header);
  for (std::size_t i = 0; i < table.header.size(); ++i) text += i == 0 ? "|---" : "|---:";
  text += "|\n";
  for (const auto& row : table.rows) add(row);
  return text + "\n";
}

/// The table scrolls sideways on a narrow page; its title does not.
inline std::string html_of(const WordTable& table) {
  std::string text = "<figure class=\"table\"><figcaption>" + escaped(table.title) +
                     "</figcaption>\n<div class=\"wide\" tabindex=\"0\"><table>\n";
  const auto add = [&](const std::vector<std::string>& row, const std::string& tag) {
    text += "<tr>";
    for (const auto& word : row) text += "<" + tag + ">" + escaped(word) + "</" + tag + ">";
    text += "</tr>\n";
  };
  text += "<thead>";
  add(table.header, "th");
  text += "</thead><tbody>\n";
  for (const auto& row : table.rows) add(row, "td");
  return text + "</tbody></table></div></figure>\n";
}

inline std::string latex_escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '\\'                                                 ? "\\textbackslash{}"
           : c == '~' || c == '^'                                    ? std::string("\\") + c + "{}"
           : c == '<' || c == '>'                                    ? std::string("$") + c + "$"
           : std::string_view("%&#_${}").find(c) < std::string::npos ? std::string("\\") + c
                                                                     : std::string(1, c);
  return out;
}

/// A table environment with booktabs' rules.
inline std::string latex_of(const WordTable& table) {
  std::string text = "\\begin{table}\n\\centering\n\\caption{" + latex_escaped(table.title) +
                     "}\n\\begin{tabular}{l" + std::string(table.header.size() - 1, 'r') + "}\n\\toprule\n";
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i == 0 ? "" : " & ") + latex_escaped(row[i]);
    text += " \\\\\n";
  };
  add(table.header);
  text += "\\midrule\n";
  for (const auto& row : table.rows) add(row);
  return text + "\\bottomrule\n\\end{tabular}\n\\end{table}\n\n";
}
}  // namespace tapestry::shell

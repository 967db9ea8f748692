#pragma once

#include "../protocol/report.hpp"
#include "comparison_figure.hpp"
#include "comparison_report.hpp"

namespace tapestry::shell {

/// Words of a comparison beside its figures.
struct ComparisonWords {
  std::string name;  ///< of its files
  std::string title;
  std::vector<std::string> notes{};
  std::string command{};  ///< that makes it again
};

namespace detail {

/// A path as seen from a folder.
inline std::string path_from(const std::string& folder, const std::string& path) {
  std::error_code failure;
  const auto relative = std::filesystem::relative(io::path_of(path), io::path_of(folder), failure);
  return failure || relative.empty() ? path : relative.generic_string();
}

inline std::string link_to(const std::string& address, const std::string& words) {
  return "<a href=\"" + escaped(address) + "\">" + escaped(words) + "</a>";
}

/// Links to the measurements and runs of a row, and a picture of its first.
inline std::string row_html(const Json& row) {
  std::string html = "<li>" + escaped(row.at("name").get<std::string>()) + ": measured in";
  for (const auto& folder : row.at("measured"))
    html += " " + link_to(folder.at("page").get<std::string>(), folder.at("name").get<std::string>());
  if (row.at("runs").empty()) return html + "; a paint of others</li>\n";
  html += "; optimised in";
  for (const auto& run : row.at("runs"))
    html += " " + link_to(run.at("page").get<std::string>(), run.at("name").get<std::string>());
  const auto picture = row.at("runs").front().at("picture").get<std::string>();
  return html + "<br><img loading=\"lazy\" width=\"320\" alt=\"\" src=\"" + escaped(picture) + "\"></li>\n";
}

/// The part of a page about one comparison. \param json  as comparison_json() writes it
inline std::string section_html(const std::string& name, const Json& json) {
  std::string html =
      "<h2 id=\"" + escaped(name) + "\">" + escaped(json.at("title").get<std::string>()) +
      "</h2>\n<div class=\"wide figure\" tabindex=\"0\"><img alt=\"the figure of the tables below\" src=\"" +
      escaped(name) + ".svg\"></div>\n";
  html += "<div class=\"panels\">\n";
  for (const auto& table : json.at("tables"))
    html += html_of({table.at("title"), table.at("header"), table.at("rows")});
  html += "</div>\n<ul>\n";
  for (const auto& note : json.at("notes")) html += "<li>" + escaped(note.get<std::string>()) + "</li>\n";
  html += "</ul>\n<details><summary>Runs and pictures</summary><ul>\n";
  for (const auto& row : json.at("rows")) html += row_html(row);
  html += "</ul></details>\n";
  if (const auto command = json.at("command").get<std::string>(); !command.empty())
    html += "<pre>" + escaped(command) + "</pre>\n";
  html += "<p>" + link_to(name + ".csv", "CSV") + " " + link_to(name + ".json", "JSON") + " " +
          link_to(name + ".md", "Markdown") + " " + link_to(name + ".tex", "LaTeX") + " " +
          link_to(name + ".svg", "SVG") + "</p>\n";
  return html;
}

}  // namespace detail

/// The tables, the notes, and where each row's figures come from; paths are relative to the folder.
inline Json comparison_json(const std::string& folder, const Comparison& comparison,
                            const std::vector<WordTable>& tables, const ComparisonWords& words) {
  Json json = {
      {"program", "tabulate"}, {"title", words.title}, {"notes", words.notes}, {"command", words.command}};
  for (const auto& table : tables)
    json["tables"].push_back({{"title", table.title}, {"header", table.header}, {"rows", table.rows}});
  for (const auto& row : comparison.rows) {
    Json entry = {
        {"name", row.name}, {"measured", Json::array()}, {"runs", Json::array()}};  // runs: none of a picture
    for (const auto& measured : row.folders) {
      const std::string path = detail::path_from(folder, measured);
      entry["measured"].push_back({{"name", path}, {"page", path}});
    }
    for (const auto& run : row.runs) {
      const std::string path = detail::path_from(folder, run);
      entry["runs"].push_back(
          {{"name", path}, {"page", path + "/report.html"}, {"picture", path + "/after.png"}});
    }
    json["rows"].push_back(entry);
  }
  json["made_by"] = comparison.made_by;
  json["computed_by"] = computed_by_json();
  return json;
}

inline std::string comparison_markdown(const std::vector<WordTable>& tables, const ComparisonWords& words) {
  const std::string title = markdown_escaped(words.title);
  std::string text = "# " + title + "\n\n![" + title + "](<" + markdown_escaped(words.name) + ".svg>)\n\n";
  for (const auto& table : tables) text += markdown_of(table);
  for (const auto& note : words.notes) text += "- " + markdown_escaped(note) + "\n";
  std::string command = words.command;
  for (char& c : command) c = c == '\n' || c == '\r' ? ' ' : c;
  return text + (command.empty() ? "" : "\n    " + command + "\n");
}

/// A page over all comparisons of a folder, in the order of their names.
inline std::string comparisons_page(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(io::path_of(folder)))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::ranges::sort(files);
  std::string contents, sections;
  for (const auto& file : files) {
    const Json json = read_json_file(file.string());
    if (!json.is_object() || json.value("program", Json()) != "tabulate") continue;
    const std::string name = file.stem().string();
    contents += "<li>" + detail::link_to("#" + name, json.at("title").get<std::string>()) + "</li>\n";
    sections += detail::section_html(name, json);
  }
  constexpr const char* style = "@media (max-width: 60em) { .figure img { max-width: none } }\n";
  return page_begin("Tables", std::string(protocol_style) + style) + "<ul>\n" + contents + "</ul>\n" +
         sections + "</body></html>\n";
}

/// Writes the files of a comparison into a folder, and the page over all comparisons there.
/// \param tables  see comparison_tables()
inline void write_comparison(const std::string& folder, const Comparison& comparison,
                             const std::vector<WordTable>& tables, const ComparisonWords& words) {
  const std::string stem = folder + "/" + words.name;
  std::string latex;
  for (const auto& table : tables) latex += latex_of(table);
  write_text(stem + ".csv", comparison_csv(comparison));
  write_text(stem + ".md", comparison_markdown(tables, words));
  write_text(stem + ".tex", latex);
  write_text(stem + ".svg", figure_svg(comparison_figure(comparison, words.title)));
  write_text(stem + ".json", report_text(comparison_json(folder, comparison, tables, words)));
  write_text(folder + "/index.html", comparisons_page(folder));
}

}  // namespace tapestry::shell

#pragma once
#include <cstdint>
#include "protocol/drawing.hpp"

namespace tapestry::shell {
/// Bytes in letters (RFC 4648, section 4).
inline std::string base64(std::string_view bytes) {
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : letters[bits >> (18 - 6 * k) & 63U];
  }
  return text;
}

/// Style of every page: light or dark by the reader's system setting.
inline constexpr const char* page_style = R"(:root { color-scheme: light dark;
  --paper: #fff; --ink: #24292f; --muted: #57606a; --line: #d8dee4; --mark: #2f81c7; --shade: #f3f5f7 }
@media (prefers-color-scheme: dark) { :root {
  --paper: #0d1117; --ink: #e6edf3; --muted: #9da7b3; --line: #30363d; --mark: #58a6ff; --shade: #161b22 } }
body { font: 15px/1.45 sans-serif; max-width: 76em; margin: 1.5em auto; padding: 0 1em;
  background: var(--paper); color: var(--ink); overflow-wrap: break-word }
a { color: var(--mark) } img { max-width: 100%; height: auto }
pre { background: var(--shade); padding: .8em; overflow: auto }
.muted, figcaption { color: var(--muted) } figure.table { margin: .8em 0 }
.wide { overflow-x: auto; width: fit-content; max-width: 100%; --end: 2.5em 100% no-repeat local; --more: .8em 100% no-repeat scroll; background:
  linear-gradient(to right, var(--paper) 40%, transparent) left / var(--end),
  linear-gradient(to left, var(--paper) 40%, transparent) right / var(--end),
  linear-gradient(to right, var(--line), transparent) left / var(--more),
  linear-gradient(to left, var(--line), transparent) right 1px top / var(--more) }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: .4em 0 .8em }
td, th { padding: .2em .8em .2em 0; text-align: right; white-space: nowrap }
th { white-space: normal; vertical-align: bottom }
td:first-child, th:first-child { text-align: left; white-space: normal; min-width: 8em }
.wide th:first-child, .wide td:first-child { position: sticky; left: 0; background: var(--paper) }
tr + tr, tbody tr { border-top: 1px solid var(--line) }
@media (max-width: 40em) { table { font-size: 13px } td, th { padding-right: .6em } }
)";

/// The beginning of a page, up to its heading.
/// \param style added to page_style
inline std::string page_begin(const std::string& title, const std::string& style) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<link rel=\"icon\" href=\"data:,\">\n<title>" +
         escaped(title) + "</title>\n<style>\n" + page_style + style + "</style></head><body>\n<h1>" +
         escaped(title) + "</h1>\n";
}
}  // namespace tapestry::shell

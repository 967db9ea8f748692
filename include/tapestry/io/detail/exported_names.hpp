#pragma once
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {
/// Class names in the metadata "names" of an ONNX model, as Ultralytics' exporters write them: the text that
/// Python prints for a dict or a list.
///
///   {0: 'person', 1: "lady's bag", 3: 'truck'}      ['person', 'car']
///
/// Numbers may be in any order and have gaps. Texts in either quotes have Python's escapes of quotes, of
/// backslashes and of characters by number. Source: The Python Language Reference, 2.4.1, String and Bytes
/// literals.
///
/// \param class_count  number of the detector's classes
/// \returns a name for each class; empty for those without one
/// \throws DomainError, with the byte, for other text, for numbers of no class, for a class or a name twice,
///         and for names that are not UTF-8, longer than 1000 bytes or not printable()
[[nodiscard]] std::vector<std::string> parse_exported_names(std::string_view text, std::size_t class_count);
}  // namespace tapestry::io

#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/io/image_file.hpp>
#include <utility>
#include <vector>

#include "base64.hpp"
#include "build_facts.hpp"
#include "command_line.hpp"
#include "contact_sheet.hpp"
#include "page.hpp"
#include "protocol/drawing.hpp"
#include "report_script.hpp"
#include "run_folder.hpp"
#include "view_list.hpp"

namespace tapestry::shell {

/// A curve over the steps of a run.
struct Curve {
  std::string name;
  std::vector<double> values;
};

/// Pairs of pictures of some views, evenly spread over all pictures of all views.
struct PicturePairs {
  std::string below_words, above_words;  ///< descriptions
  std::vector<Bitmap> below{}, above{};
};

/// A page about pictures of measured views. Empty parts are left out.
struct ReportPage {
  std::string title;
  std::string command;  ///< command that repeats the measurement
  std::uint64_t seed = 0;
  double seconds = 0;
  std::string findings{};  ///< HTML
  ViewList list{};
  PicturePairs pairs{};
  std::vector<std::pair<std::string, Array<std::uint8_t, 3>>> atlases{};  ///< each with its words
  std::string glb{};                                                      ///< the bytes of a painted.glb
  std::vector<Curve> curves{};
  std::vector<std::string> files{};  ///< beside the page, to link
  Json options{};
};

/// The command line with the settings that differ from the defaults.
/// \param left_out  settings of a run without options
std::string repeating_line(const std::string& program, const Json& settings, const Json& left_out);

/// A page that needs no other file and no network: findings, two pictures of a view over each other, the
/// views in a list that can be sorted and filtered, the car in 3-D, the paint, curves, links to the files
/// beside the page, and the options.
std::string page_html(const ReportPage& page);

}  // namespace tapestry::shell

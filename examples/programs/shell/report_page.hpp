#pragma once
#include <tapestry/io/image_file.hpp>
#include "contact_sheet.hpp"
#include "view_list.hpp"

namespace tapestry::shell {
/// A curve over the steps of a run, or over what else it has a value for each.
struct Curve {
  std::string name;
  std::vector<double> values;
  std::string over = "step";
};

/// A curve of each number of a run's steps, as Step::all lists them.
template <class Step>
std::vector<Curve> curves_of(const std::vector<Step>& history) {
  std::vector<Curve> curves;
  for (const auto& number : Step::all) {
    curves.push_back({number.name, {}});
    for (const auto& step : history) curves.back().values.push_back(step.*number.value);
  }
  return curves;
}

/// Pictures of some views, each view in several ways.
struct ViewPictures {
  std::vector<std::size_t> places{};  ///< among the pictures of all views
  /// Each view with its words, and a picture for each place.
  std::vector<std::pair<std::string, std::vector<MarkedPicture>>> ways{};
};

inline constexpr std::size_t most_large_views = 24;

/// A page about pictures of measured views. Empty parts are left out.
struct ReportPage {
  std::string title;
  std::string command;  ///< command that repeats the measurement
  std::uint64_t seed = 0;
  double seconds = 0;
  std::string verdict{};
  std::string findings{};  ///< HTML
  ViewList list{};
  ViewPictures pictures{};
  std::vector<std::pair<std::string, Array<std::uint8_t, 3>>> atlases{};  ///< each with its words
  std::string glb{};                                                      ///< the bytes of a painted.glb
  std::vector<Curve> curves{};
  std::vector<std::string> files{};  ///< beside the page, to link
  Json options{};
};

/// The command line with the settings that differ from the defaults.
/// \param left_out  settings of a run without options
std::string repeating_line(const std::string& program, const Json& settings, const Json& left_out);

/// Most bytes of a page, except with thousands of views. Pictures take the rest of the page: their JPEGs get
/// coarser and, if that is not enough, fewer, then smaller, with labels drawn at that size.
inline constexpr std::size_t most_bytes_of_a_page = 4'000'000;

/// A page that needs nothing else, no file and no network: the verdict, large pictures of a view to step
/// through, findings, each view in a list that sorts and filters, the car to turn, the paint, curves, links
/// to the files beside it, and the options. A car of over 1.5 MB is linked instead.
std::string page_html(const ReportPage& page);
}  // namespace tapestry::shell

#pragma once
#include "report.hpp"
#include "report_page.hpp"

namespace tapestry::shell {
/// \param report  must outlive the list
ViewList list_of(const RunReport& report, std::vector<ViewFacts> views);

/// The page of a run or of its evaluation, without its pictures, paint, car and files.
/// \param report  must outlive the page
ReportPage page_of(const RunReport& report, std::string title, std::string command, ViewList list);

/// Prints words_on_photographs() of a page's views, and adds them to its findings.
void remark_on_photographs(ReportPage& page);
}  // namespace tapestry::shell

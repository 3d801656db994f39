// SPDX-License-Identifier: MIT
#include "mmlins/report/report.hpp"

#include <string_view>

#include "mmlins/base/text_file.hpp"
#include "mmlins/report/page_files.hpp"
#include "mmlins/report/report_data.hpp"

namespace mmlins::report {
namespace {

/// The page's file of that name, as it was compiled in.
std::string page_file(std::string_view name) {
  for (const PageFile& file : page_files()) {
    if (file.name == name) return file.text;
  }
  MMLINS_CHECK(false);
  return {};
}

std::string all_scripts() {
  std::string text;
  for (const char* name : {"base.js", "charts.js", "map.js", "timeline.js", "sections.js", "main.js"}) text += page_file(name);
  return text;
}

void put(std::string& page, std::string_view mark, const std::string& text) {
  const auto at = page.find(mark);
  MMLINS_CHECK(at != std::string::npos);
  page.replace(at, mark.size(), text);
}

// Inside a script element only "</script" and "<!--" are special, and both begin with "<".
std::string safe_inside_script(const std::string& json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace

Result<std::string> report_html(const ReportInput& input) {
  MMLINS_CHECK(!input.result.scans.empty());
  const auto data = report_data(input);
  if (!data) return data.error();
  std::string page = page_file("page.html");
  // Texts from outside may hold bytes that are no UTF-8, such as file names.
  const std::string json = data->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  put(page, "{{style}}", page_file("style.css"));
  put(page, "{{script}}", all_scripts());
  put(page, "{{data}}", safe_inside_script(json));
  return page;
}

Status write_report(const std::string& path, const ReportInput& input) {
  const auto page = report_html(input);
  if (!page) return make_error(page.error().code, "{}: {}", path, page.error().message);
  return write_text_file(path, *page);
}

}  // namespace mmlins::report

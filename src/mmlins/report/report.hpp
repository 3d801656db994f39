// SPDX-License-Identifier: MIT
#pragma once
// report.html: one file that shows a whole run and needs nothing else, neither network nor program.
// docs/formats.md describes it.

#include <optional>
#include <string>

#include "mmlins/io/recording_info.hpp"
#include "mmlins/pipeline/run_files.hpp"
#include "mmlins/report/truth.hpp"

namespace mmlins::report {

/// What a report is made of. All of it must outlive the call.
struct ReportInput {
  const pipeline::RunResult& result;     ///< with at least one scan
  const pipeline::RunSource& source;
  const sensor::Rig& rig;
  const pipeline::SlamConfig& config;
  const io::RecordingInfo* recording = nullptr;  ///< what was found in it; left out of the report if null
  const TruthComparison* truth = nullptr;        ///< none was given if null
};

/// The page with its data. Error: the picture of the map cannot be encoded.
[[nodiscard]] Result<std::string> report_html(const ReportInput& input);

/// Writes the page; it appears under its name only when it is complete. Error: one line with the path.
[[nodiscard]] Status write_report(const std::string& path, const ReportInput& input);

}  // namespace mmlins::report

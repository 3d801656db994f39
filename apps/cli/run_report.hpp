// SPDX-License-Identifier: MIT
#pragma once
// report.html of a run, and what --truth adds to it.

#include "mmlins/report/report.hpp"

namespace mmlins::cli {

/// The truth that --truth names; an empty trajectory without it. Rows that had to be put right give a warning.
[[nodiscard]] Result<math::Trajectory> read_truth(const std::string& file);

/// Compares with the truth if there is one, prints the figures, and writes DIR/report.html. A truth of another time than
/// the recording gives a warning and a report without it.
[[nodiscard]] Status write_report(const std::string& folder, report::ReportInput input, const math::Trajectory& truth,
                                  const std::string& truth_file);

}  // namespace mmlins::cli

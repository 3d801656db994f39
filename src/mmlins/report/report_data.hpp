// SPDX-License-Identifier: MIT
#pragma once
// What the page is drawn from: one JSON object. docs/formats.md names its keys.

#include <nlohmann/json.hpp>

#include "mmlins/report/decimate.hpp"
#include "mmlins/report/report.hpp"

namespace mmlins::report {

using nlohmann::ordered_json;

/// The whole object.
[[nodiscard]] Result<ordered_json> report_data(const ReportInput& input);

// Its parts, one file each.

/// The figures of summary.json under the same keys, and the times of work as a histogram.
[[nodiscard]] ordered_json figures_json(const ReportInput& input);
/// Maps, closures and merges with their evidence.
[[nodiscard]] ordered_json maps_json(const ReportInput& input);
[[nodiscard]] ordered_json closures_json(const ReportInput& input);
[[nodiscard]] ordered_json merges_json(const ReportInput& input);
/// Stretches of scans of the same state, cause and map: [from, to, state, cause, map], times in seconds.
[[nodiscard]] ordered_json stretches_json(const ReportInput& input);
/// The trajectory in the frame of the first map, thinned; every change of state or map is in it.
[[nodiscard]] ordered_json path_json(const ReportInput& input);
/// Quantities over time, thinned.
[[nodiscard]] ordered_json curves_json(const ReportInput& input);
/// Figures of the truth; null if none was given.
[[nodiscard]] ordered_json truth_json(const ReportInput& input);
/// What was found in the recording; null if that is not known.
[[nodiscard]] ordered_json recording_json(const ReportInput& input);
[[nodiscard]] ordered_json settings_json(const ReportInput& input);

/// Seconds since the first scan.
[[nodiscard]] double seconds_of(const ReportInput& input, Time time);
/// The value with that many significant digits; null if it is no number. An infinite one becomes 1e9.
[[nodiscard]] ordered_json rounded(double value, int digits);

}  // namespace mmlins::report

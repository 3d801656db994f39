// SPDX-License-Identifier: MIT
#pragma once
// Trajectories as text in the TUM format: one pose per line, "time x y z qx qy qz qw", seconds and
// metres. Times never pass through a double, so that nanoseconds survive.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "mmlins/base/result.hpp"
#include "mmlins/math/trajectory.hpp"

namespace mmlins::eval {

/// A trajectory as read, in increasing order, and what had to be put right for that.
struct TumFile {
  math::Trajectory poses;
  int num_out_of_order = 0;  ///< rows earlier than the row before them; sorted in
  int num_duplicates = 0;    ///< rows with the stamp of another row; the first one is kept
};

/// Reads TUM text; '#' starts a comment line, blank lines are skipped, quaternions are normalised.
/// Errors: a row that is no pose (with its line), no pose at all.
/// @param source  what to call the text in messages: its file name
[[nodiscard]] Result<TumFile> parse_tum(std::string_view text, const std::string& source);
/// The same, from a file.
[[nodiscard]] Result<TumFile> read_tum(const std::string& path);

/// One line without its end: absolute time with 9 decimals, position and quaternion with 9 and 12.
[[nodiscard]] std::string tum_line(const math::StampedPose& stamped);
/// Writes all poses; the file appears under its name only when it is complete.
[[nodiscard]] Status write_tum(const std::string& path, const math::Trajectory& trajectory);

/// Decimal text of seconds, "12.5" or "1.25e+01", as nanoseconds, rounded to the nearest; nothing if it
/// is not a number or does not fit.
[[nodiscard]] std::optional<std::int64_t> parse_seconds_as_ns(std::string_view text);

/// A time as seconds with 9 decimals.
[[nodiscard]] std::string seconds_text(Time time);

}  // namespace mmlins::eval

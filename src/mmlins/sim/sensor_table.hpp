// SPDX-License-Identifier: MIT
#pragma once
// What is known about a kind of LiDAR, as a table: a user adds a sensor by writing one, without code. The
// known ones are the files of config/sensors/, built into the program.

#include <string>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/sim/named_text.hpp"

namespace mmlins::sim {

enum class PatternKind { kSpinning, kNodding, kRosette };

/// One laser of a row.
struct LaserSpec {
  double elevation_deg = 0.0;
  double azimuth_deg = 0.0;  ///< offset from the rotor's direction, counted from x towards y

  [[nodiscard]] Fields fields();
};

struct SensorTable {
  PatternKind pattern = PatternKind::kSpinning;
  std::vector<LaserSpec> lasers;
  int lasers_at_once = 1;
  double laser_period_us = 0.0;
  double column_period_us = 100.0;
  double point_period_us = 5.0;
  double beam_origin = 0.0;
  double field_of_view_deg = 70.0;
  double rosette_first_hz = 121.567;
  double rosette_second_hz = -77.733;
  double nearest = 0.5;
  double farthest = 100.0;
  double range_step = 0.0;
  double beam_divergence_deg = 0.15;

  [[nodiscard]] Fields fields();
};

/// The built-in tables by name, in alphabetical order.
[[nodiscard]] std::vector<NamedText> sensor_texts();

/// The built-in table of that name, or the YAML file at that path.
/// Errors: an unknown name (lists all), an unreadable file, a table that makes no sense.
[[nodiscard]] Result<SensorTable> load_sensor_table(const std::string& name_or_path);

}  // namespace mmlins::sim

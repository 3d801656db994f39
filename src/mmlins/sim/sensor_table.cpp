// SPDX-License-Identifier: MIT
#include "mmlins/sim/sensor_table.hpp"

#include "mmlins/config/yaml_config.hpp"

namespace mmlins::sim {

namespace {

Status apply_named(const Fields& fields, const std::string& name) {
  std::string names;
  for (const NamedText& text : sensor_texts()) {
    if (text.name == name) return config::apply_yaml(fields, text.yaml, name);
    names += (names.empty() ? "" : ", ") + text.name;
  }
  return make_error(ErrorCode::kNotFound,
                    "sensor.model: there is no sensor '{}'; accepted: {}, or the path of a .yaml table", name,
                    names);
}

Status validate(const SensorTable& table, const std::string& source) {
  constexpr std::size_t kMostLasers = 128;
  if (table.pattern != PatternKind::kNodding && (table.lasers.empty() || table.lasers.size() > kMostLasers)) {
    return make_error(ErrorCode::kInvalid, "{}: lasers must be a list of 1 to {}; it has {}", source,
                      kMostLasers, table.lasers.size());
  }
  if (table.nearest >= table.farthest) {
    return make_error(ErrorCode::kInvalid, "{}: nearest ({} m) must be less than farthest ({} m)", source,
                      table.nearest, table.farthest);
  }
  const auto firings = static_cast<double>(table.lasers.size()) / table.lasers_at_once;
  if (table.pattern == PatternKind::kSpinning &&
      firings * table.laser_period_us > table.column_period_us + 1e-6) {
    return make_error(ErrorCode::kInvalid,
                      "{}: column_period_us ({}) is too short for its lasers, which take {} us", source,
                      table.column_period_us, firings * table.laser_period_us);
  }
  return {};
}

}  // namespace

Result<SensorTable> load_sensor_table(const std::string& name_or_path) {
  SensorTable table;
  const Fields fields = table.fields();
  const bool is_file = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".yaml");
  const Status loaded =
      is_file ? config::apply_yaml_file(fields, name_or_path) : apply_named(fields, name_or_path);
  if (!loaded) return loaded.error();
  if (const Status status = validate(table, name_or_path); !status) return status.error();
  return table;
}

Fields LaserSpec::fields() {
  return {
      field("elevation_deg", elevation_deg, "deg", {-90.0, 90.0}, "above the horizon"),
      field("azimuth_deg", azimuth_deg, "deg", {-180.0, 180.0}, "offset from the direction of the rotor"),
  };
}

Fields SensorTable::fields() {
  return {
      field("pattern", pattern, {"spinning", "nodding", "rosette"},
            "a turning row of lasers, one mirror that turns and nods (MID-360), or two prisms (Avia)"),
      groups("lasers", lasers, "in the order of firing"),
      field("lasers_at_once", lasers_at_once, "", {1, 128}, "that fire together, of a spinning sensor"),
      field("laser_period_us", laser_period_us, "us", {0.0, 1e4},
            "from one firing to the next within a column"),
      field("column_period_us", column_period_us, "us", {1.0, 1e6}, "from one column to the next"),
      field("point_period_us", point_period_us, "us", {0.1, 1e6}, "from point to point, if it does not spin"),
      field("beam_origin", beam_origin, "m", {0.0, 0.5},
            "distance from the axis at which beams start, in the direction of the rotor"),
      field("field_of_view_deg", field_of_view_deg, "deg", {1.0, 179.0}, "whole width of a rosette"),
      field("rosette_first_hz", rosette_first_hz, "Hz", {-1e4, 1e4}, "of the first prism"),
      field("rosette_second_hz", rosette_second_hz, "Hz", {-1e4, 1e4},
            "of the second; negative: the other way round"),
      field("nearest", nearest, "m", {0.0, 100.0}, "nearer returns are lost"),
      field("farthest", farthest, "m", {0.1, 1000.0}, "farther returns are lost"),
      field("range_step", range_step, "m", {0.0, 1.0}, "ranges are multiples of it; 0: any"),
      field("beam_divergence_deg", beam_divergence_deg, "deg", {0.0, 5.0}, "full angle of the beam"),
  };
}

}  // namespace mmlins::sim

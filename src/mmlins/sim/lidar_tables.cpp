// SPDX-License-Identifier: MIT
#include "mmlins/sim/lidar_tables.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "mmlins/base/check.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::sim {

namespace {

Duration from_us(double microseconds) { return from_seconds(1e-6 * microseconds); }

SpinningTable spinning_table(const SensorTable& sensor) {
  SpinningTable table;
  for (const LaserSpec& laser : sensor.lasers) {
    table.elevations_deg.push_back(laser.elevation_deg);
    table.azimuths_deg.push_back(laser.azimuth_deg);
  }
  table.lasers_at_once = static_cast<std::size_t>(sensor.lasers_at_once);
  table.between_lasers = from_us(sensor.laser_period_us);
  table.between_columns = from_us(sensor.column_period_us);
  table.beam_origin = sensor.beam_origin;
  return table;
}

RosetteTable rosette_table(const SensorTable& sensor) {
  RosetteTable table{0.5 * sensor.field_of_view_deg,
                     sensor.rosette_first_hz,
                     sensor.rosette_second_hz,
                     {},
                     from_us(sensor.point_period_us)};
  for (const LaserSpec& laser : sensor.lasers) table.line_offsets_deg.push_back(laser.elevation_deg);
  return table;
}

// Of a config that validate() has accepted.
SensorTable table_of(const std::string& model) {
  auto table = load_sensor_table(model);
  MMLINS_CHECK(table.ok());
  return std::move(table).value();
}

}  // namespace

std::unique_ptr<ScanPattern> make_pattern(const LidarConfig& config, const SensorTable& sensor,
                                          std::uint64_t seed) {
  if (sensor.pattern == PatternKind::kNodding) return make_nodding({from_us(sensor.point_period_us)});
  if (sensor.pattern == PatternKind::kRosette) return make_rosette(rosette_table(sensor));
  SpinningTable table = spinning_table(sensor);
  if (config.columns > 0) {
    table.between_columns = from_seconds(1.0 / config.rate_hz / config.columns);
    // Fewer columns leave the lasers their time; more must squeeze them.
    const auto lasers = static_cast<std::int64_t>(table.elevations_deg.size());
    table.between_lasers = std::min(table.between_lasers, table.between_columns / lasers);
  }
  Random random(sub_seed(seed, 1));
  return make_spinning(table, config.rate_hz * (1.0 + config.rotor_slip), random.uniform());
}

std::string LidarConfig::model_name() const { return std::filesystem::path(model).stem().string(); }

SensorTable LidarConfig::table() const {
  SensorTable table = table_of(model);
  if (min_range > 0.0) table.nearest = min_range;
  if (max_range > 0.0) table.farthest = max_range;
  if (range_step >= 0.0) table.range_step = range_step;
  return table;
}
double LidarConfig::nearest() const { return table().nearest; }
double LidarConfig::farthest() const { return table().farthest; }

math::SE3 LidarConfig::T_imu_lidar() const {
  const auto& q = q_imu_lidar_xyzw;
  return {Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix(),
          {p_imu_lidar[0], p_imu_lidar[1], p_imu_lidar[2]}};
}

Fields LidarConfig::fields() {
  return {
      field("model", model, "which LiDAR: the name of a built-in table, or the path of a .yaml table"),
      field("rate_hz", rate_hz, "Hz", {1.0, 50.0}, "scans per second"),
      field("columns", columns, "", {0, 8192},
            "firings of all lasers per scan of a spinning sensor; 0: its own number"),
      field("point_share", point_share, "", {0.01, 1.0}, "share of the points that the driver passes on"),
      field("rotor_slip", rotor_slip, "", {-0.1, 0.1},
            "relative difference of the rotor's rate from the scan rate"),
      field("min_range", min_range, "m", {0.0, 100.0}, "nearer returns are lost; 0: the sensor's own"),
      field("max_range", max_range, "m", {0.0, 500.0}, "farther returns are lost; 0: the sensor's own"),
      field("range_noise", range_noise, "m", {0.0, 1.0}, "standard deviation of one range"),
      field("range_step", range_step, "m", {-1.0, 1.0},
            "ranges are multiples of it; -1: the sensor's own; 0: any"),
      field("mixed_pixels", mixed_pixels, "", {0.0, 1.0},
            "share of the beams half on an edge that return a range between front and back"),
      field("laser_bias", laser_bias, "m", {0.0, 0.1},
            "standard deviation of the constant range errors that calibration leaves to each laser"),
      field("dropout", dropout, "", {0.0, 1.0}, "share of shots that are lost for no reason"),
      field("max_incidence_deg", max_incidence_deg, "deg", {10.0, 88.0},
            "more grazing shots do not come back"),
      field("latency", latency, "s", {0.0, 1.0}, "from the end of a scan to its record time"),
      field("p_imu_lidar", p_imu_lidar, "m", {-100.0, 100.0}, "origin of the LiDAR in the IMU frame"),
      field("q_imu_lidar_xyzw", q_imu_lidar_xyzw, "", {-1.0, 1.0},
            "rotation that takes directions from the LiDAR frame to the IMU frame, quaternion x y z w"),
  };
}

}  // namespace mmlins::sim

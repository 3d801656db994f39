// SPDX-License-Identifier: MIT
#include "mmlins/sim/lidar_tables.hpp"

#include <cmath>

#include "mmlins/sim/random.hpp"

namespace mmlins::sim {

namespace {

std::vector<std::string> model_names() { return {"vlp16", "hdl32e", "os1_64", "mid360", "avia"}; }

SpinningTable vlp16_table() {
  return {
      {-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15}, {}, Duration{2304}, Duration{55296}};
}

SpinningTable hdl32e_table() {
  SpinningTable table{{}, {}, Duration{1152}, Duration{46080}};
  constexpr double kStep = 4.0 / 3.0;
  for (int i = 0; i < 16; ++i) {
    table.elevations_deg.push_back(-30.67 + kStep * i);
    table.elevations_deg.push_back(-9.33 + kStep * i);
  }
  return table;
}

SpinningTable os1_64_table() {
  SpinningTable table{{}, {3.164, 1.055, -1.055, -3.164}, Duration{0}, Duration{97656}};
  for (int i = 0; i < 64; ++i) table.elevations_deg.push_back(16.611 - 2.0 * 16.611 / 63.0 * i);
  return table;
}

SpinningTable spinning_table(LidarModelKind model) {
  if (model == LidarModelKind::kVlp16) return vlp16_table();
  if (model == LidarModelKind::kHdl32e) return hdl32e_table();
  return os1_64_table();
}

}  // namespace

RangeLimits range_limits(LidarModelKind model) {
  switch (model) {
    case LidarModelKind::kVlp16:
      return {0.5, 100.0};
    case LidarModelKind::kHdl32e:
      return {0.5, 80.0};
    case LidarModelKind::kOs1_64:
      return {0.5, 100.0};
    case LidarModelKind::kMid360:
      return {0.2, 70.0};
    case LidarModelKind::kAvia:
      break;
  }
  return {0.5, 150.0};
}

std::unique_ptr<ScanPattern> make_pattern(const LidarConfig& config, std::uint64_t seed) {
  if (config.model == LidarModelKind::kMid360) return make_nodding({});
  if (config.model == LidarModelKind::kAvia) {
    RosetteTable table;
    table.line_offsets_deg = {-1.4, -0.84, -0.28, 0.28, 0.84, 1.4};
    return make_rosette(table);
  }
  SpinningTable table = spinning_table(config.model);
  if (config.columns > 0) {
    table.between_columns = from_seconds(1.0 / config.rate_hz / config.columns);
    // Fewer columns leave the lasers their time; more must squeeze them.
    const auto lasers = static_cast<std::int64_t>(table.elevations_deg.size());
    table.between_lasers = std::min(table.between_lasers, table.between_columns / lasers);
  }
  Random random(sub_seed(seed, 1));
  return make_spinning(table, config.rate_hz * (1.0 + config.rotor_slip), random.uniform());
}

std::string LidarConfig::model_name() const { return model_names()[static_cast<std::size_t>(model)]; }
double LidarConfig::nearest() const { return min_range > 0.0 ? min_range : range_limits(model).nearest; }
double LidarConfig::farthest() const { return max_range > 0.0 ? max_range : range_limits(model).farthest; }

math::SE3 LidarConfig::T_imu_lidar() const {
  const auto& q = q_imu_lidar_xyzw;
  return {Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix(),
          {p_imu_lidar[0], p_imu_lidar[1], p_imu_lidar[2]}};
}

Fields LidarConfig::fields() {
  return {
      field("model", model, model_names(), "which LiDAR"),
      field("rate_hz", rate_hz, "Hz", {1.0, 50.0}, "scans per second"),
      field("columns", columns, "", {0, 8192},
            "firings of all lasers per scan of a spinning sensor; 0: its own number"),
      field("point_share", point_share, "", {0.01, 1.0}, "share of the points that the driver passes on"),
      field("rotor_slip", rotor_slip, "", {-0.1, 0.1},
            "relative difference of the rotor's rate from the scan rate"),
      field("min_range", min_range, "m", {0.0, 100.0}, "nearer returns are lost; 0: the sensor's own"),
      field("max_range", max_range, "m", {0.0, 500.0}, "farther returns are lost; 0: the sensor's own"),
      field("range_noise", range_noise, "m", {0.0, 1.0}, "standard deviation of one range"),
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

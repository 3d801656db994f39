// SPDX-License-Identifier: MIT
#pragma once
// The LiDAR: casts every point of a scan from where the sensor was when that point was fired, so that the
// motion distortion is the true one, and spoils the ranges the way a real sensor does.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/sensor/lidar_scan.hpp"
#include "mmlins/sim/motion.hpp"
#include "mmlins/sim/random.hpp"
#include "mmlins/sim/scan_pattern.hpp"
#include "mmlins/sim/sensor_table.hpp"
#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

struct LidarConfig {
  std::string model = "vlp16";
  double rate_hz = 10.0;
  int columns = 0;
  double point_share = 1.0;
  double rotor_slip = 0.003;
  double min_range = 0.0;
  double max_range = 0.0;
  double range_noise = 0.012;
  double range_step = -1.0;
  double mixed_pixels = 0.1;
  double laser_bias = 0.004;
  double dropout = 0.03;
  double max_incidence_deg = 84.0;
  double latency = 0.004;
  std::array<double, 3> p_imu_lidar{0.05, 0.02, 0.12};
  std::array<double, 4> q_imu_lidar_xyzw{0.0, 0.0, 0.0, 1.0};

  [[nodiscard]] Fields fields();
  [[nodiscard]] std::string model_name() const;
  /// The sensor's own values unless the config sets others; validate() has accepted the model.
  [[nodiscard]] SensorTable table() const;
  [[nodiscard]] double nearest() const;
  [[nodiscard]] double farthest() const;
  [[nodiscard]] math::SE3 T_imu_lidar() const;
};

/// What tests need to know about the points of a scan, element by element.
struct ScanTruth {
  std::vector<float> ranges;  ///< without noise [m]
  std::vector<int> surfaces;  ///< for World::distance
};

struct SimulatedScan {
  sensor::LidarScan scan;
  ScanTruth truth;
};

class LidarModel {
 public:
  LidarModel(const LidarConfig& config, std::uint64_t seed);

  /// The scan that is measured during [begin, end); times count from the start of the recording. World and
  /// motion must be in the same frame.
  [[nodiscard]] SimulatedScan scan(const World& world, const Motion& motion, Duration begin,
                                   Duration end) const;
  /// Time from one scan to the next.
  [[nodiscard]] Duration period() const;

 private:
  struct Return {
    Eigen::Vector3f point;
    float range = 0.0F;  // without noise [m]
    float intensity = 0.0F;
    int surface = -1;  // -1: nothing came back
  };
  [[nodiscard]] std::vector<Return> shoot(const World& world, const Motion& motion,
                                          const std::vector<Beam>& beams) const;
  [[nodiscard]] double mixed_range(const World& world, const Ray& ray, const Hit& hit, Random& random) const;
  [[nodiscard]] Return measure(const World& world, const Ray& ray, const Beam& beam) const;

  LidarConfig config_;
  SensorTable table_;
  std::uint64_t seed_;
  math::SE3 T_imu_lidar_;
  double min_cos_incidence_;
  std::vector<double> laser_biases_;  // by ring [m]
  std::unique_ptr<ScanPattern> pattern_;
};

}  // namespace mmlins::sim

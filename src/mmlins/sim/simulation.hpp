// SPDX-License-Identifier: MIT
#pragma once
// A recording that is made up while it is read: the same interface as a bag, with the truth beside it.

#include <memory>
#include <vector>

#include "mmlins/degrade/scan_degrader.hpp"
#include "mmlins/math/trajectory.hpp"
#include "mmlins/sensor/dataset.hpp"
#include "mmlins/sensor/rig.hpp"
#include "mmlins/sim/imu_model.hpp"
#include "mmlins/sim/lidar_model.hpp"
#include "mmlins/sim/motion.hpp"
#include "mmlins/sim/moving_world.hpp"
#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

struct SimulationConfig {
  double duration = 30.0;
  int seed = 1;
  WorldConfig world;
  LidarConfig sensor;
  ImuConfig imu;
  TrajectoryConfig trajectory;
  std::vector<degrade::EventSpec> events;

  [[nodiscard]] Fields fields();
};

/// Checks what ranges alone cannot.
/// @param source  what to call the config in the message: a scenario or file name
[[nodiscard]] Status validate(const SimulationConfig& config, const std::string& source);

class Simulation : public sensor::Dataset {
 public:
  /// The config must be valid (validate()).
  explicit Simulation(const SimulationConfig& config);
  /// In another world than the config's; open_simulation() uses it for those that are read from files.
  Simulation(const SimulationConfig& config, std::unique_ptr<World> world);

  /// IMU samples and scans in the order in which they would be recorded: a scan is complete only after its
  /// last point, and comes after the IMU samples of that time.
  [[nodiscard]] Result<sensor::Item> next() override;
  [[nodiscard]] double progress() const override;
  /// When the item that next() gave last was recorded.
  [[nodiscard]] Time record_time() const { return record_time_; }
  /// Noise-free ranges of the scan that next() gave last; points that an event has moved are on surface -1.
  [[nodiscard]] const ScanTruth& scan_truth() const { return scan_truth_; }

  [[nodiscard]] const SimulationConfig& config() const { return config_; }
  [[nodiscard]] Time start_time() const;
  [[nodiscard]] Time end_time() const;
  [[nodiscard]] math::SE3 T_world_imu(Time time) const;
  [[nodiscard]] math::Vector3d velocity_world(Time time) const;
  /// Without gravity [m/s^2].
  [[nodiscard]] math::Vector3d acceleration_world(Time time) const;
  [[nodiscard]] math::Vector3d angular_rate_imu(Time time) const;
  [[nodiscard]] ImuBias bias(Time time) const;
  /// Poses of the IMU from start to end.
  [[nodiscard]] math::Trajectory truth(double rate_hz = 100.0) const;
  /// What a ray in the world meets of all that stands still.
  [[nodiscard]] std::optional<Hit> cast(const Ray& ray_world, double max_range) const;
  /// Distance of a point from a surface named by scan_truth(), at the time of the point [m].
  [[nodiscard]] double distance_to_surface(const math::Vector3d& p_world, int surface,
                                           Time time = Time{}) const;
  /// People and cars; their places are in the frame of the scene.
  [[nodiscard]] const std::vector<Mover>& movers() const;
  /// The description that a user of such a recording would have.
  [[nodiscard]] sensor::Rig rig() const;

 private:
  [[nodiscard]] Kinematics kinematics(Time time) const;
  [[nodiscard]] Duration scan_begin(std::int64_t index) const;
  /// The next scan; nothing if an event has it lost.
  [[nodiscard]] std::optional<sensor::LidarScan> make_scan();
  [[nodiscard]] std::optional<sensor::LidarScan> degrade(sensor::LidarScan scan);

  SimulationConfig config_;
  math::SE3 T_world_scene_;
  std::unique_ptr<Motion> motion_;  // in the scene
  std::unique_ptr<World> world_;
  const MovingWorld* moving_ = nullptr;  // the world, if anything moves in it
  ImuModel imu_;
  LidarModel lidar_;
  degrade::ScanDegrader degrader_;
  std::int64_t next_imu_ = 0;
  std::int64_t next_scan_ = 0;
  Time record_time_;
  ScanTruth scan_truth_;
};

}  // namespace mmlins::sim

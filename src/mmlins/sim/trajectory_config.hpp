// SPDX-License-Identifier: MIT
#pragma once
// How the carrier moves, as a user writes it down.

#include <vector>

#include "mmlins/base/config_fields.hpp"

namespace mmlins::sim {

/// What carries the sensors; kCustom: what the fields say.
enum class Carrier { kCustom, kVehicle, kHandheld, kQuadruped, kDrone };

enum class PathStyle { kEllipse, kRoute };

/// A corner of a course that somebody wrote down; in the coordinates of the scene.
struct RouteCorner {
  double x = 0.0, y = 0.0;  ///< [m]
  double z = 0.0;           ///< of the ground [m]

  [[nodiscard]] Fields fields();
};

/// A pause on the way. The carrier stands during all of it: it slows down before and starts again after.
struct Stop {
  double at = 0.0;        ///< after the start of the recording [s]
  double duration = 5.0;  ///< [s]

  [[nodiscard]] Fields fields();
};

struct TrajectoryConfig {
  Carrier carrier = Carrier::kCustom;
  PathStyle style = PathStyle::kEllipse;
  std::vector<RouteCorner> route;
  double speed = 1.2;
  double stand_still = 3.0;
  bool start_in_motion = false;
  std::vector<Stop> stops;
  double ramp = 3.0;
  double start_lap = 0.1;
  bool reverse = false;
  double semi_axis_x = 9.0;
  double semi_axis_y = 6.0;
  double corner_ratio = 0.6;
  double corner_smoothing = 0.8;
  double height = 1.3;
  double rise = 0.1;
  double bob = 0.01;
  double bob_hz = 1.7;
  double sway_deg = 3.0;
  double sway_hz = 0.45;
  double look_deg = 8.0;
  double look_hz = 0.21;
  double mount_yaw_deg = 17.0;

  /// With the values of the carrier in place of all that are left at their defaults.
  [[nodiscard]] TrajectoryConfig resolved() const;
  [[nodiscard]] Fields fields();
};

/// The carriers by name, in the order of the enum.
[[nodiscard]] std::vector<std::string> carrier_names();

}  // namespace mmlins::sim

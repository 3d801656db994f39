// SPDX-License-Identifier: MIT
#pragma once
// How a map began and ended, and what is known of the way from the one before to it.

#include <optional>
#include <string_view>

#include "mmlins/odometry/scan_result.hpp"

namespace mmlins::odometry {

enum class MapBeginning {
  kAtRest,    ///< the robot stood still
  kInMotion,  ///< found from a window of scans in motion
  kAfterGap,  ///< with the velocity, biases and gravity that the IMU carried through the gap
};

[[nodiscard]] std::string_view to_string(MapBeginning beginning);

/// The motion that the IMU alone carried, from the last scan believed in one map to the beginning of the next, as it looks
/// from there: velocity, gravity and biases that the new map found tell where the IMU went astray (imu/hindsight.hpp).
struct GapEdge {
  int from_map = 0;
  Time last;                 ///< in the map before
  Time first;                ///< in this one
  math::SE3 T_last_first;    ///< maps the IMU frame at `first` to that at `last`
  bool is_known = true;      ///< false if the IMU was silent on the way, or cannot have led to what the new map found
  math::Matrix6d covariance = math::Matrix6d::Zero();  ///< of the error e in T Exp(e), [rotation; translation]
};

struct MapRecord {
  int id = 0;
  MapBeginning beginning = MapBeginning::kAtRest;
  Time begin;
  Time last_believed;              ///< the last scan that was placed in it
  Cause why_ended = Cause::kNone;  ///< why it fell asleep; none while it is awake
  std::optional<GapEdge> gap;      ///< none for the first map
  math::SE3 T_first_map;           ///< its place in the frame of the first map, by the gap edges
};

}  // namespace mmlins::odometry

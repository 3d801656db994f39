// SPDX-License-Identifier: MIT
#include "mmlins/odometry/scan_result.hpp"

namespace mmlins::odometry {

bool is_placed(TrackingState state) {
  return state == TrackingState::kInitializing || state == TrackingState::kTracking || state == TrackingState::kDegraded;
}

std::string_view to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kInitializing: return "INITIALIZING";
    case TrackingState::kTracking: return "TRACKING";
    case TrackingState::kDegraded: return "DEGRADED";
    case TrackingState::kBridging: return "BRIDGING";
    case TrackingState::kLost: return "LOST";
    case TrackingState::kRelocating: return "RELOCATING";
  }
  return "";
}

std::string_view to_string(Cause cause) {
  switch (cause) {
    case Cause::kNone: return "";
    case Cause::kNoPoints: return "no points";
    case Cause::kBlocked: return "blocked";
    case Cause::kTooFewMatches: return "too few matches";
    case Cause::kWeakDirections: return "weak directions";
    case Cause::kAmbiguous: return "place in doubt";
    case Cause::kImuDisagrees: return "IMU and LiDAR disagree";
    case Cause::kImuGap: return "IMU gap";
    case Cause::kNoStart: return "no start";
  }
  return "";
}

}  // namespace mmlins::odometry

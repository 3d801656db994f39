// SPDX-License-Identifier: MIT
#include "mmlins/odometry/scan_result.hpp"

namespace mmlins::odometry {

std::string_view to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kInitializing: return "INITIALIZING";
    case TrackingState::kTracking: return "TRACKING";
    case TrackingState::kDegraded: return "DEGRADED";
    case TrackingState::kBridging: return "BRIDGING";
  }
  return "";
}

std::string_view to_string(Cause cause) {
  switch (cause) {
    case Cause::kNone: return "";
    case Cause::kNoPoints: return "no points";
    case Cause::kTooFewMatches: return "too few matches";
    case Cause::kWeakDirections: return "weak directions";
    case Cause::kImuGap: return "IMU gap";
  }
  return "";
}

}  // namespace mmlins::odometry

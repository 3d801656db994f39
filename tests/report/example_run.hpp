// SPDX-License-Identifier: MIT
#pragma once
// A run made by hand: ten scans a second along x at 1 m/s, dark from scan 40 to 59, a second map after that which was
// joined to the first.

#include "mmlins/report/report.hpp"

namespace mmlins::report {

inline odometry::TrackingState state_of(int scan) {
  if (scan < 10) return odometry::TrackingState::kInitializing;
  if (scan < 40 || scan >= 60) return odometry::TrackingState::kTracking;
  return scan < 50 ? odometry::TrackingState::kBridging : odometry::TrackingState::kLost;
}

inline pipeline::ScanRecord example_scan(int i) {
  pipeline::ScanRecord scan;
  scan.time = time_from_ns(1'700'000'000'000'000'000 + i * 100'000'000LL);
  scan.state = state_of(i);
  scan.cause = is_placed(scan.state) ? odometry::Cause::kNone : odometry::Cause::kNoPoints;
  scan.map_id = i < 60 ? 0 : 1;
  scan.T_odom_imu.t = {0.1 * i, 0.0, 0.0};
  // A bend, so that an alignment is determined.
  scan.T_world_imu.t = {0.1 * i, i < 50 ? 0.0 : 0.1 * (i - 50), 0.0};
  scan.iterations = is_placed(scan.state) ? 2 : 0;
  for (std::size_t k = 0; k < 3; ++k) scan.observability.translation[k].std = is_placed(scan.state) ? 0.001 * (3.0 - k) : 0.0;
  scan.read_ms = 1.0;
  scan.times.update = i == 70 ? 30.0 : 3.0;
  return scan;
}

inline pipeline::RunResult example_run(int num_scans = 100) {
  pipeline::RunResult result;
  for (int i = 0; i < num_scans; ++i) result.scans.push_back(example_scan(i));
  const auto time_of = [&](int i) { return result.scans[static_cast<std::size_t>(i)].time; };
  odometry::MapRecord first;
  first.begin = time_of(0);
  first.last_believed = time_of(39);
  first.why_ended = odometry::Cause::kNoPoints;
  odometry::MapRecord second;
  second.id = 1;
  second.beginning = odometry::MapBeginning::kAfterGap;
  second.begin = time_of(60);
  second.last_believed = time_of(num_scans - 1);
  second.gap = odometry::GapEdge{0, first.last_believed, second.begin, {}, true, math::Matrix6d::Identity() * 0.04};
  result.maps = {first, second};
  result.mapping.worlds = {0, 0};
  for (const int i : {20, 80}) result.mapping.keyframes.push_back({time_of(i), i < 60 ? 0 : 1, {}, result.scans[static_cast<std::size_t>(i)].T_world_imu});
  mapping::Closure closure;
  closure.source = 1;
  closure.source_map = 1;
  closure.time = time_of(80);
  closure.state = mapping::ClosureState::kCounts;
  closure.overlap = 0.75;
  closure.reason = "accepted: </script> overlap 0.75";
  result.mapping.closures = {closure};
  mapping::Merge merge;
  merge.time = time_of(82);
  merge.world = 1;
  merge.closures = {0};
  merge.T_new_old.t = {3.0, 4.0, 0.0};
  result.mapping.merges = {merge};
  result.wall_seconds = 0.5;
  return result;
}

}  // namespace mmlins::report

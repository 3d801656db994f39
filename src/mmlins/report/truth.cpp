// SPDX-License-Identifier: MIT
#include "mmlins/report/truth.hpp"

#include <limits>
#include <numbers>

namespace mmlins::report {
namespace {

math::Trajectory poses_of(const pipeline::RunResult& result, math::SE3 pipeline::ScanRecord::*pose) {
  math::Trajectory trajectory;
  for (const pipeline::ScanRecord& scan : result.scans) trajectory.push_back({scan.time, scan.*pose});
  return trajectory;
}

// The pairs are in the order of the scans, but scans without truth have none.
ErrorSeries series_of(const pipeline::RunResult& result, const eval::PosePairs& pairs, const math::SE3& T_truth_estimate) {
  ErrorSeries series;
  auto pair = pairs.begin();
  for (const pipeline::ScanRecord& scan : result.scans) {
    series.position.push_back(std::numeric_limits<double>::quiet_NaN());
    series.rotation_deg.push_back(std::numeric_limits<double>::quiet_NaN());
    if (pair == pairs.end() || pair->time != scan.time) continue;
    const math::SE3 error = pair->T_truth_imu.inverse() * (T_truth_estimate * pair->T_estimate_imu);
    series.position.back() = error.t.norm();
    series.rotation_deg.back() = math::se3_log(error).head<3>().norm() * 180.0 / std::numbers::pi;
    ++pair;
  }
  return series;
}

// A straight drive does not determine a roll about itself; then heading and place must do.
Result<eval::Evaluation> evaluate(const math::Trajectory& truth, const math::Trajectory& estimate, const std::string& file) {
  auto evaluation = eval::evaluate(truth, estimate, eval::Alignment::kSe3);
  if (!evaluation) evaluation = eval::evaluate(truth, estimate, eval::Alignment::kYaw);
  if (evaluation) return evaluation;
  const std::string& reason = evaluation.error().message;
  return make_error(evaluation.error().code, "{}: {}", file, reason.substr(0, reason.find("; use --align")));
}

}  // namespace

Result<TruthComparison> compare_with_truth(const pipeline::RunResult& result, const math::Trajectory& truth,
                                           const std::string& file) {
  const math::Trajectory odometry = poses_of(result, &pipeline::ScanRecord::T_odom_imu);
  const math::Trajectory trajectory = poses_of(result, &pipeline::ScanRecord::T_world_imu);
  const auto of_odometry = evaluate(truth, odometry, file);
  if (!of_odometry) return of_odometry.error();
  const auto of_trajectory = evaluate(truth, trajectory, file);
  if (!of_trajectory) return of_trajectory.error();
  TruthComparison comparison{file, *of_odometry, *of_trajectory, {}, {}, {}};
  comparison.odometry_errors = series_of(result, eval::match_poses(truth, odometry), of_odometry->T_truth_estimate);
  const eval::PosePairs pairs = eval::match_poses(truth, trajectory);
  comparison.trajectory_errors = series_of(result, pairs, of_trajectory->T_truth_estimate);
  const math::SE3 T_world_truth = of_trajectory->T_truth_estimate.inverse();
  for (const eval::PosePair& pair : pairs) comparison.path_world.push_back(T_world_truth * pair.T_truth_imu.t);
  return comparison;
}

}  // namespace mmlins::report

// SPDX-License-Identifier: MIT
#include "mmlins/eval/evaluation.hpp"

#include "mmlins/eval/trajectory_file.hpp"

namespace mmlins::eval {
namespace {

constexpr std::size_t kFewestPoses = 3;  ///< fewer do not fix a rotation

std::string time_range(const math::Trajectory& trajectory) {
  return seconds_text(trajectory.front().time) + " to " + seconds_text(trajectory.back().time) + " s";
}

Status check_overlap(const math::Trajectory& truth, const math::Trajectory& estimate,
                     std::size_t num_matched) {
  if (truth.empty() || estimate.empty()) return make_error(ErrorCode::kInvalid, "a trajectory without poses");
  if (truth.back().time < estimate.front().time || estimate.back().time < truth.front().time) {
    return make_error(ErrorCode::kInvalid,
                      "no common time: the truth covers {}, the estimate {}; are both of one run?",
                      time_range(truth), time_range(estimate));
  }
  if (num_matched < kFewestPoses) {
    return make_error(ErrorCode::kInvalid,
                      "only {} common poses, at least {} are needed: the truth covers {} in {} poses, the "
                      "estimate {} in {}",
                      num_matched, kFewestPoses, time_range(truth), truth.size(), time_range(estimate),
                      estimate.size());
  }
  return {};
}

std::optional<math::SE3> align_pairs(const PosePairs& pairs, Alignment alignment) {
  std::vector<math::Vector3d> p_truth;
  std::vector<math::Vector3d> p_estimate;
  for (const PosePair& pair : pairs) {
    p_truth.push_back(pair.T_truth_imu.t);
    p_estimate.push_back(pair.T_estimate_imu.t);
  }
  return align_positions(p_truth, p_estimate, alignment);
}

}  // namespace

Result<Evaluation> evaluate(const math::Trajectory& truth, const math::Trajectory& estimate,
                            Alignment alignment) {
  const PosePairs pairs = match_poses(truth, estimate);
  if (const Status status = check_overlap(truth, estimate, pairs.size()); !status) return status.error();
  const std::optional<math::SE3> T_truth_estimate = align_pairs(pairs, alignment);
  if (!T_truth_estimate) {
    return make_error(
        ErrorCode::kInvalid,
        "the path does not determine the alignment (all at one place or on one line); use --align {}none",
        alignment == Alignment::kSe3 ? "yaw or " : "");
  }
  Evaluation evaluation;
  evaluation.num_truth = static_cast<int>(truth.size());
  evaluation.num_estimate = static_cast<int>(estimate.size());
  evaluation.num_matched = static_cast<int>(pairs.size());
  evaluation.duration = to_seconds(truth.back().time - truth.front().time);
  evaluation.path_length = path_length(pairs);
  evaluation.T_truth_estimate = *T_truth_estimate;
  evaluation.absolute = absolute_errors(pairs, *T_truth_estimate);
  evaluation.per_second = relative_errors_over_time(pairs, std::chrono::seconds(1));
  evaluation.per_100m = relative_errors_per_100m(pairs);
  evaluation.end_to_end = end_to_end_error(pairs);
  evaluation.coverage = coverage_of(truth, estimate);
  return evaluation;
}

}  // namespace mmlins::eval

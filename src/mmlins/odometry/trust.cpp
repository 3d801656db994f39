// SPDX-License-Identifier: MIT
#include "mmlins/odometry/trust.hpp"

#include <algorithm>
#include <vector>

namespace mmlins::odometry {

Fields TrustConfig::fields() {
  return {
      field("usual_window", usual_window, "s", {1.0, 600.0},
            "what is usual is the median over this much tracking"),
      field("min_explained", min_explained, "", {0.0, 1.0},
            "a scan of which the map explains less than this share of the usual is not believed"),
      field("insert_explained", insert_explained, "", {0.0, 1.0},
            "a scan explained less than this enters the map only once the next one has been believed too"),
      field("min_explained_again", min_explained_again, "", {0.0, 1.0},
            "the same after the IMU has contradicted, until a scan is believed again"),
      field("doubtful_drift", doubtful_drift, "m", {0.0, 100.0},
            "a pose that may have drifted by this standard deviation is in doubt: a return from there has to prove itself"),
      field("short_absence", short_absence, "s", {0.0, 60.0},
            "after less than this the first scan needs no more than any other"),
      field("max_return_chi2", max_return_chi2, "", {1.0, 1e6},
            "after an absence: largest squared distance of the pose from the IMU's, in its standard "
            "deviations"),
      field("max_return_residual", max_return_residual, "", {1.0, 1000.0},
            "after an absence: residuals larger than this many times the usual are no match, whatever share they are of"),
      field("collapsed_range", collapsed_range, "", {0.0, 1.0},
            "an unexplained scan whose median range is below this share of the usual is blocked"),
      field("collapsed_count", collapsed_count, "", {0.0, 1.0}, "the same for its number of points"),
      field("agreement_window", agreement_window, "s", {0.2, 10.0},
            "IMU and LiDAR are compared over this time"),
      field("max_disagreement", max_disagreement, "m", {0.01, 100.0},
            "they disagree when their motions differ by more, with what the IMU's own doubt explains on top"),
      field("max_disagreement_deg", max_disagreement_deg, "deg", {0.1, 180.0}, "the same for rotation"),
      field("max_step", max_step, "m", {0.0, 100.0},
            "a return into the map that corrects the pose by more moves the map, not odom: odom never jumps"),
      field("max_step_deg", max_step_deg, "deg", {0.0, 180.0}, "the same for rotation"),
  };
}

namespace {

constexpr std::size_t kEnough = 10;

}  // namespace

void RunningMedian::push(Time time, double value, Duration window) {
  values_.emplace_back(time, value);
  // What was usual before an absence longer than the window is better than nothing.
  while (values_.size() > kEnough && values_.front().first < time - window) values_.pop_front();
}

std::optional<double> RunningMedian::median() const {
  if (values_.size() < kEnough) return std::nullopt;
  std::vector<double> sorted;
  sorted.reserve(values_.size());
  for (const auto& [time, value] : values_) sorted.push_back(value);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

bool TrustJudge::has_collapsed(const Evidence& evidence) const {
  const auto range = range_.median();
  const auto count = count_.median();
  return (range && evidence.median_range < config_.collapsed_range * *range) ||
         (count && evidence.num_points < config_.collapsed_count * *count);
}

bool TrustJudge::is_absent(const Evidence& evidence) const {
  return was_contradicted_ ||
         (last_trusted_ && evidence.time - *last_trusted_ > from_seconds(config_.short_absence));
}

bool TrustJudge::is_doubtful(const Evidence& evidence) const {
  return was_contradicted_ || (is_absent(evidence) && evidence.drift > config_.doubtful_drift);
}

Cause TrustJudge::reason_to_refuse(const Evidence& evidence) const {
  if (evidence.num_points == 0) return Cause::kNoPoints;
  const Cause unexplained = has_collapsed(evidence) ? Cause::kBlocked : Cause::kTooFewMatches;
  if (!evidence.matched) return unexplained;
  const bool doubtful = is_doubtful(evidence);
  // A few points find a few planes anywhere: to return, the sensor must see as far as it did.
  if (doubtful && has_collapsed(evidence)) return Cause::kBlocked;
  const double share = was_contradicted_ ? config_.min_explained_again : config_.min_explained;
  const auto usual = explained_.median();
  if (usual && evidence.explained < share * *usual) return unexplained;
  const auto usual_residual = residual_.median();
  if (is_absent(evidence) && usual_residual && evidence.residual_rms > config_.max_return_residual * *usual_residual) {
    return unexplained;
  }
  if (is_absent(evidence) && evidence.return_chi2 > config_.max_return_chi2) return Cause::kImuDisagrees;
  if (evidence.ambiguous) return Cause::kAmbiguous;
  if (evidence.imu_disagrees) return Cause::kImuDisagrees;
  return Cause::kNone;
}

bool TrustJudge::is_explained_as_usual(double explained) const {
  const auto usual = explained_.median();
  return !usual || explained >= config_.insert_explained * *usual;
}

Verdict TrustJudge::judge(const Evidence& evidence) {
  const Cause cause = reason_to_refuse(evidence);
  was_contradicted_ = cause == Cause::kImuDisagrees || (was_contradicted_ && (cause != Cause::kNone || evidence.provisional));
  if (cause != Cause::kNone) return {false, cause};
  if (!evidence.provisional) learn(evidence);
  return {true, Cause::kNone};
}

void TrustJudge::learn(const Evidence& evidence) {
  const Duration window = from_seconds(config_.usual_window);
  explained_.push(evidence.time, evidence.explained, window);
  residual_.push(evidence.time, evidence.residual_rms, window);
  range_.push(evidence.time, evidence.median_range, window);
  count_.push(evidence.time, evidence.num_points, window);
  last_trusted_ = evidence.time;
}

}  // namespace mmlins::odometry

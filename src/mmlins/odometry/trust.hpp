// SPDX-License-Identifier: MIT
#pragma once
// Whether the match of a scan is to be believed: does the map explain as much of the scan as it usually does,
// and does the IMU agree? All yardsticks are shares of what was usual, or metres: the same for every sensor.
// docs/math/degeneracy.md, section 3.

#include <deque>
#include <optional>
#include <utility>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/time.hpp"
#include "mmlins/odometry/scan_result.hpp"

namespace mmlins::odometry {

struct TrustConfig {
  double usual_window = 30.0;
  double min_explained = 0.3;
  double insert_explained = 0.7;
  double min_explained_again = 0.5;
  double short_absence = 0.5;
  double doubtful_drift = 0.3;
  double max_return_chi2 = 30.0;
  double max_return_residual = 5.0;
  double collapsed_range = 0.5;
  double collapsed_count = 0.1;
  double agreement_window = 1.0;
  double max_disagreement = 0.3;
  double max_disagreement_deg = 2.0;
  double max_step = 0.1;
  double max_step_deg = 1.0;

  [[nodiscard]] Fields fields();
};

/// Median of what was pushed within a window of time.
class RunningMedian {
 public:
  void push(Time time, double value, Duration window);
  /// Nothing until there are ten values.
  [[nodiscard]] std::optional<double> median() const;

 private:
  std::deque<std::pair<Time, double>> values_;
};

/// What a scan gives to judge by.
struct Evidence {
  Time time{};
  int num_points = 0;         ///< within the range gate
  double median_range = 0.0;  ///< [m]
  bool matched = false;       ///< enough matches for an update
  double explained = 0.0;     ///< share of the keypoints that match
  double residual_rms = 0.0;  ///< of those that do, point to plane [m]
  double drift = 0.0;         ///< standard deviation of the predicted position since it was last believed [m]
  double return_chi2 = 0.0;   ///< shift of the update against the prediction's own doubt
  bool imu_disagrees = false;  ///< over the last while, MotionAgreement
  bool ambiguous = false;      ///< another place explains the scan as well, or may do so
  bool provisional = false;    ///< believed for now: a return from afar has to prove itself still
};

struct Verdict {
  bool trusted = false;
  Cause cause = Cause::kNone;
};

class TrustJudge {
 public:
  explicit TrustJudge(const TrustConfig& config) : config_(config) {}

  [[nodiscard]] Verdict judge(const Evidence& evidence);
  /// Takes the scan for usual without judging it.
  void learn(const Evidence& evidence);
  /// Whether enough was tracked to know what is usual.
  [[nodiscard]] bool knows_the_usual() const { return explained_.median().has_value(); }
  /// Whether the map explains as much of a scan as it should of one that is to grow it.
  [[nodiscard]] bool is_explained_as_usual(double explained) const;
  /// Whether the scan has shrunk against what was usual before trust was lost, as under a cover.
  [[nodiscard]] bool has_collapsed(const Evidence& evidence) const;

 private:
  [[nodiscard]] bool is_absent(const Evidence& evidence) const;
  [[nodiscard]] bool is_doubtful(const Evidence& evidence) const;
  [[nodiscard]] Cause reason_to_refuse(const Evidence& evidence) const;

  TrustConfig config_;
  RunningMedian explained_;
  RunningMedian residual_;
  RunningMedian range_;
  RunningMedian count_;
  std::optional<Time> last_trusted_;
  bool was_contradicted_ = false;  // by the IMU; until a match is believed again
};

}  // namespace mmlins::odometry

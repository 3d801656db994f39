// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>
#include <limits>

#include "mmlins/report/report_data.hpp"

namespace mmlins::report {
namespace {

using pipeline::ScanRecord;

constexpr std::size_t kMaxSamples = 2000;     // per curve
constexpr std::size_t kMaxPathPoints = 6000;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

class CurveList {
 public:
  explicit CurveList(const ReportInput& input) : input_(input) {
    for (const ScanRecord& scan : input.result.scans) seconds_.push_back(seconds_of(input, scan.time));
  }

  void add(const std::string& name, const std::function<double(const ScanRecord&)>& value) {
    std::vector<double> values;
    for (const ScanRecord& scan : input_.result.scans) values.push_back(value(scan));
    add(name, values);
  }
  void add(const std::string& name, const std::vector<double>& values) {
    const Curve curve = decimate(seconds_, values, kMaxSamples);
    ordered_json t = ordered_json::array();
    ordered_json y = ordered_json::array();
    for (const double seconds : curve.t) t.push_back(rounded(seconds, 7));
    for (const double v : curve.y) y.push_back(rounded(v, 4));
    json_[name] = {{"t", std::move(t)}, {"y", std::move(y)}};
  }
  [[nodiscard]] ordered_json take() { return std::move(json_); }

 private:
  const ReportInput& input_;
  std::vector<double> seconds_;
  ordered_json json_;
};

/// Without an update of the filter there are zeros, which mean nothing.
double if_matched(const ScanRecord& scan, double value) { return scan.iterations > 0 ? value : kNothing; }

void add_observability(CurveList& curves) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string number = std::to_string(i + 1);
    curves.add("t" + number + "_std", [=](const ScanRecord& r) { return if_matched(r, r.observability.translation[i].std); });
    curves.add("r" + number + "_std", [=](const ScanRecord& r) { return if_matched(r, r.observability.rotation[i].std); });
    curves.add("t" + number + "_noise_share",
               [=](const ScanRecord& r) { return if_matched(r, r.observability.translation[i].noise_share); });
    curves.add("r" + number + "_noise_share",
               [=](const ScanRecord& r) { return if_matched(r, r.observability.rotation[i].noise_share); });
  }
}

std::size_t path_step(std::size_t num_scans) { return (num_scans + kMaxPathPoints - 1) / kMaxPathPoints; }

bool changes(const ScanRecord& a, const ScanRecord& b) {
  return a.state != b.state || a.map_id != b.map_id || a.cause != b.cause;
}

}  // namespace

ordered_json curves_json(const ReportInput& input) {
  CurveList curves(input);
  add_observability(curves);
  curves.add("std_position_m", [](const ScanRecord& r) { return r.position_std.maxCoeff(); });
  curves.add("speed_m_s", [](const ScanRecord& r) { return r.v_imu.norm(); });
  curves.add("points", [](const ScanRecord& r) { return static_cast<double>(r.num_points); });
  curves.add("matches", [](const ScanRecord& r) { return static_cast<double>(r.num_matches); });
  curves.add("explained", [](const ScanRecord& r) { return r.explained; });
  curves.add("residual_rms_m", [](const ScanRecord& r) { return if_matched(r, r.residual_rms); });
  curves.add("disagreement_m", [](const ScanRecord& r) { return r.disagreement > 0.0 ? r.disagreement : kNothing; });
  curves.add("total_ms", [](const ScanRecord& r) { return r.total_ms(); });
  if (input.truth != nullptr) {
    curves.add("odometry_error_m", input.truth->odometry_errors.position);
    curves.add("trajectory_error_m", input.truth->trajectory_errors.position);
    curves.add("odometry_error_deg", input.truth->odometry_errors.rotation_deg);
    curves.add("trajectory_error_deg", input.truth->trajectory_errors.rotation_deg);
  }
  return curves.take();
}

ordered_json path_json(const ReportInput& input) {
  const auto& scans = input.result.scans;
  const std::size_t step = path_step(scans.size());
  ordered_json path = {{"t", ordered_json::array()}, {"x", ordered_json::array()}, {"y", ordered_json::array()},
                       {"z", ordered_json::array()}, {"state", ordered_json::array()}, {"map", ordered_json::array()}};
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const bool at_change = (i > 0 && changes(scans[i - 1], scans[i])) || (i + 1 < scans.size() && changes(scans[i], scans[i + 1]));
    if (i % step != 0 && i + 1 != scans.size() && !at_change) continue;
    const math::Vector3d& p = scans[i].T_world_imu.t;
    path["t"].push_back(rounded(seconds_of(input, scans[i].time), 7));
    path["x"].push_back(rounded(p.x(), 6));
    path["y"].push_back(rounded(p.y(), 6));
    path["z"].push_back(rounded(p.z(), 6));
    path["state"].push_back(static_cast<int>(scans[i].state));
    path["map"].push_back(scans[i].map_id);
  }
  return path;
}

}  // namespace mmlins::report

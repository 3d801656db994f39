// SPDX-License-Identifier: MIT
#include "mmlins/report/report_data.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/report/findings.hpp"
#include "mmlins/report/map_picture.hpp"
#include "mmlins/report/settings.hpp"

namespace mmlins::report {
namespace {

constexpr double kInfinite = 1e9;  // JSON has none

ordered_json finding_json(const Finding& finding) {
  return {{"level", std::string(to_string(finding.level))}, {"text", finding.text}};
}

ordered_json findings_json(const ReportInput& input) {
  const Findings findings = findings_of(input);
  ordered_json list = ordered_json::array();
  for (const Finding& finding : findings.list) list.push_back(finding_json(finding));
  return {{"headline", finding_json(findings.headline)}, {"list", std::move(list)}};
}

Result<ordered_json> picture_json(const ReportInput& input) {
  std::vector<Eigen::Vector3d> path;
  for (const pipeline::ScanRecord& scan : input.result.scans) path.push_back(scan.T_world_imu.t);
  const std::vector<Eigen::Vector3f> points = input.result.map.points_map();
  const double finest = 0.5 * input.config.output.map_voxel;
  const MapPicture picture = draw_from_above(points, path, {.min_metres_per_pixel = finest});
  const auto png = encode_png(picture.image);
  if (!png) return png.error();
  return ordered_json{{"png", base64(*png)},
                      {"width", picture.image.width},
                      {"height", picture.image.height},
                      {"metres_per_pixel", picture.metres_per_pixel},
                      {"min_x", picture.min_x},
                      {"max_y", picture.max_y},
                      {"low_m", picture.low},
                      {"high_m", picture.high}};
}

template <typename Enum>
ordered_json names_of(Enum last) {
  ordered_json names = ordered_json::array();
  for (int i = 0; i <= static_cast<int>(last); ++i) names.push_back(std::string(to_string(static_cast<Enum>(i))));
  return names;
}

ordered_json limits_json(const pipeline::SlamConfig& config) {
  const degeneracy::ObservabilityConfig& o = config.odometry.observability;
  return {{"weak_position_m", o.weak_position},
          {"weak_rotation_rad", o.weak_rotation_deg * std::numbers::pi / 180.0},
          {"weak_noise_share", o.weak_noise_share}};
}

ordered_json list_json(const Fields& fields, const Fields& defaults) {
  ordered_json list = ordered_json::array();
  for (const Setting& setting : list_settings(fields, defaults)) {
    ordered_json entry = {{"key", setting.path}, {"value", setting.value}, {"unit", setting.unit}, {"meaning", setting.meaning}};
    if (setting.differs()) entry["default"] = setting.default_value;
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

Result<ordered_json> report_data(const ReportInput& input) {
  auto picture = picture_json(input);
  if (!picture) return picture.error();
  ordered_json data;
  data["format"] = 1;
  data["figures"] = figures_json(input);
  data["findings"] = findings_json(input);
  data["begin"] = pipeline::stamp(input.result.scans.front().time);
  data["states"] = names_of(odometry::TrackingState::kRelocating);
  data["causes"] = names_of(odometry::Cause::kNoStart);
  data["stretches"] = stretches_json(input);
  data["path"] = path_json(input);
  data["maps"] = maps_json(input);
  data["closures"] = closures_json(input);
  data["merges"] = merges_json(input);
  data["curves"] = curves_json(input);
  data["limits"] = limits_json(input.config);
  data["truth"] = truth_json(input);
  data["recording"] = recording_json(input);
  data["settings"] = settings_json(input);
  data["picture"] = std::move(*picture);
  return data;
}

ordered_json settings_json(const ReportInput& input) {
  pipeline::SlamConfig config = input.config;
  pipeline::SlamConfig default_config;
  sensor::Rig rig = input.rig;
  sensor::Rig default_rig;
  return {{"config", list_json(config.fields(), default_config.fields())},
          {"rig", list_json(rig.fields(), default_rig.fields())}};
}

double seconds_of(const ReportInput& input, Time time) { return to_seconds(time - input.result.scans.front().time); }

ordered_json rounded(double value, int digits) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0.0 ? kInfinite : -kInfinite;
  if (value == 0.0) return 0;
  const int decimals = digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  // Of the two ways only the one with an exact power of ten gives the number that prints short.
  if (decimals < 0) return std::round(value / std::pow(10.0, -decimals)) * std::pow(10.0, -decimals);
  return std::round(value * std::pow(10.0, decimals)) / std::pow(10.0, decimals);
}

}  // namespace mmlins::report

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numbers>

#include "mmlins/report/report_data.hpp"

namespace mmlins::report {
namespace {

constexpr std::size_t kMostRefused = 2000;  // closures that changed nothing; the others are all there

constexpr double kDegrees = 180.0 / std::numbers::pi;

ordered_json gap_json(const ReportInput& input, const odometry::GapEdge& gap) {
  const math::Vector6d std = gap.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return {{"from_map", gap.from_map},
          {"from_s", rounded(seconds_of(input, gap.last), 9)},
          {"to_s", rounded(seconds_of(input, gap.first), 9)},
          {"seconds", rounded(to_seconds(gap.first - gap.last), 9)},
          {"motion_is_known", gap.is_known},
          {"metres", rounded(gap.T_last_first.t.norm(), 5)},
          {"std_rotation_deg", rounded(kDegrees * std.head<3>().maxCoeff(), 4)},
          {"std_position_m", rounded(std.tail<3>().maxCoeff(), 4)}};
}

/// Where a keyframe lies in the end and when it was; nothing if there is none of that number.
ordered_json keyframe_json(const ReportInput& input, int index) {
  const auto& keyframes = input.result.mapping.keyframes;
  if (index < 0 || static_cast<std::size_t>(index) >= keyframes.size()) return nullptr;
  const pipeline::KeyframePlace& keyframe = keyframes[static_cast<std::size_t>(index)];
  const math::Vector3d& p = keyframe.T_world_imu.t;
  return {{"t", rounded(seconds_of(input, keyframe.time), 9)}, {"x", rounded(p.x(), 6)}, {"y", rounded(p.y(), 6)}};
}

ordered_json closure_json(const ReportInput& input, const mapping::Closure& c) {
  return {{"id", c.id},
          {"t", rounded(seconds_of(input, c.time), 9)},
          {"source", keyframe_json(input, c.source)},
          {"target", keyframe_json(input, c.target)},
          {"source_map", c.source_map},
          {"target_map", c.target_map},
          {"origin", std::string(to_string(c.origin))},
          {"state", std::string(to_string(c.state))},
          {"score", rounded(c.score, 3)},
          {"overlap", rounded(c.overlap, 3)},
          {"residual_rms_m", rounded(c.residual_rms, 4)},
          {"moved_m", rounded(c.moved, 4)},
          {"turned_deg", c.turned < 0.0 ? ordered_json(-1) : rounded(kDegrees * c.turned, 4)},
          {"reason", c.reason}};
}

}  // namespace

ordered_json maps_json(const ReportInput& input) {
  ordered_json maps = ordered_json::array();
  const auto& worlds = input.result.mapping.worlds;
  for (const odometry::MapRecord& map : input.result.maps) {
    const auto index = static_cast<std::size_t>(map.id);
    maps.push_back({{"id", map.id},
                    {"world", index < worlds.size() ? worlds[index] : map.id},
                    {"began", std::string(to_string(map.beginning))},
                    {"begin_s", rounded(seconds_of(input, map.begin), 9)},
                    {"last_believed_s", rounded(seconds_of(input, map.last_believed), 9)},
                    {"fell_asleep", std::string(to_string(map.why_ended))},
                    {"gap", map.gap ? gap_json(input, *map.gap) : ordered_json(nullptr)}});
  }
  return maps;
}

ordered_json closures_json(const ReportInput& input) {
  const auto& closures = input.result.mapping.closures;
  const auto changes_nothing = [](const mapping::Closure& c) {
    return c.state == mapping::ClosureState::kRefused || c.state == mapping::ClosureState::kConfirmed;
  };
  const auto num_idle = static_cast<std::size_t>(std::count_if(closures.begin(), closures.end(), changes_nothing));
  const std::size_t every = (num_idle + kMostRefused - 1) / kMostRefused;
  ordered_json list = ordered_json::array();
  std::size_t idle = 0;
  for (const mapping::Closure& closure : closures) {
    if (changes_nothing(closure) && idle++ % every != 0) continue;
    list.push_back(closure_json(input, closure));
  }
  return list;
}

ordered_json merges_json(const ReportInput& input) {
  ordered_json merges = ordered_json::array();
  for (const mapping::Merge& merge : input.result.mapping.merges) {
    merges.push_back({{"id", merge.number()},
                      {"t", rounded(seconds_of(input, merge.time), 9)},
                      {"map", merge.world},
                      {"into", merge.into},
                      {"closures", merge.closures},
                      {"enhancing", merge.enhancing},
                      {"moved_m", rounded(merge.T_new_old.t.norm(), 5)},
                      {"turned_deg", rounded(kDegrees * math::se3_log(merge.T_new_old).head<3>().norm(), 4)},
                      {"motion_between_was_known", merge.prior_known}});
    if (merge.undone) merges.back()["undone"] = {{"t", rounded(seconds_of(input, *merge.undone), 9)}, {"why", merge.why_undone}};
  }
  return merges;
}

ordered_json stretches_json(const ReportInput& input) {
  const auto& scans = input.result.scans;
  ordered_json stretches = ordered_json::array();
  std::size_t first = 0;
  for (std::size_t i = 1; i <= scans.size(); ++i) {
    const bool goes_on = i < scans.size() && scans[i].state == scans[first].state && scans[i].cause == scans[first].cause &&
                         scans[i].map_id == scans[first].map_id;
    if (goes_on) continue;
    // Up to the next scan: something was going on in between as well.
    const Time end = scans[std::min(i, scans.size() - 1)].time;
    stretches.push_back({rounded(seconds_of(input, scans[first].time), 9), rounded(seconds_of(input, end), 9),
                         static_cast<int>(scans[first].state), static_cast<int>(scans[first].cause), scans[first].map_id,
                         i - first});
    first = i;
  }
  return stretches;
}

}  // namespace mmlins::report

// SPDX-License-Identifier: MIT
#include "mmlins/mapping/surroundings.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "mmlins/base/check.hpp"

namespace mmlins::mapping {
namespace {

using math::SE3;

/// Keeps those nearest to `place`, in the order of their ids.
void keep_nearest(std::vector<PlacedKeyframe>& keyframes, const math::Vector3d& place, std::size_t most) {
  if (keyframes.size() > most) {
    std::stable_sort(keyframes.begin(), keyframes.end(),
                     [&](const PlacedKeyframe& a, const PlacedKeyframe& b) {
                       return (a.T_map_imu.t - place).squaredNorm() < (b.T_map_imu.t - place).squaredNorm();
                     });
    keyframes.resize(most);
  }
  std::sort(keyframes.begin(), keyframes.end(),
            [](const PlacedKeyframe& a, const PlacedKeyframe& b) { return a.id < b.id; });
}

}  // namespace

SE3 place_world(const MapGraph& graph, const std::vector<SE3>& T_map_imu, const std::optional<SE3>& before,
                const RebuildConfig& config) {
  const SE3 T_world_latest = graph.T_world_keyframe(graph.num_keyframes() - 1);
  if (before) {
    const SE3 apart = T_map_imu.back().inverse() * *before * T_world_latest;
    const double turned = math::so3_log(apart.R).norm() * 180.0 / std::numbers::pi;
    if (apart.t.norm() <= config.kept_within && turned <= config.kept_within_deg) return *before;
  }
  return T_map_imu.back() * T_world_latest.inverse();
}

Surroundings surroundings_of_latest(const MapGraph& graph, const std::vector<SE3>& T_map_imu,
                                    const SE3& T_map_world, const RebuildConfig& config) {
  MMLINS_CHECK(!T_map_imu.empty() && static_cast<int>(T_map_imu.size()) == graph.num_keyframes());
  Surroundings result;
  const int latest = graph.num_keyframes() - 1;
  const int map = graph.map_of(latest), world = graph.world_of(map);
  const SE3& T_map_latest = T_map_imu.back();
  double farthest = 0.0;
  for (int id = latest; id >= 0; --id) {
    const SE3& T_grown = T_map_imu[static_cast<std::size_t>(id)];
    const bool grows = graph.map_of(id) == map && !graph.is_bridged(id, latest);
    if (grows) farthest = std::max(farthest, (T_grown.t - T_map_latest.t).norm());
    if (graph.world_of(graph.map_of(id)) != world) continue;
    const SE3 T_now = T_map_world * graph.T_world_keyframe(id);
    const double distance = (T_now.t - T_map_latest.t).norm();
    if (distance > config.near) continue;
    // Who has not been away since has all of that place in the map still.
    const bool holds =
        grows && farthest <= config.held_within && (T_now.t - T_grown.t).norm() <= config.moved;
    const bool is_recent = grows && graph.odometer(latest) - graph.odometer(id) <= config.recent;
    if (!holds && !is_recent) {
      result.known.push_back({id, T_now});
    } else if (static_cast<int>(result.recent.size()) < config.max_keyframes) {
      result.recent.push_back(id);
    }
  }
  keep_nearest(result.known, T_map_latest.t, static_cast<std::size_t>(config.max_keyframes));
  std::reverse(result.recent.begin(), result.recent.end());
  return result;
}

}  // namespace mmlins::mapping

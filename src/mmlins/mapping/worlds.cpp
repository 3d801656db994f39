// SPDX-License-Identifier: MIT
#include "mmlins/mapping/worlds.hpp"

#include <algorithm>
#include <utility>

#include "mmlins/base/stopwatch.hpp"

namespace mmlins::mapping {
namespace {

using math::SE3;

/// Odometry that has to bend more than this (mean squared normalised error) is bent by something false.
constexpr double kMaxOdometryChi2 = 1.5;

}  // namespace

bool Worlds::is_between(const Closure& closure, int world_a, int world_b) const {
  const int source = graph.world_of(closure.source_map), target = graph.world_of(closure.target_map);
  return std::minmax(source, target) == std::minmax(world_a, world_b);
}

Placement Worlds::placement_of(const Closure& closure, bool source_moves) const {
  const SE3 T_world_source = graph.T_world_keyframe(closure.source);
  const SE3 T_world_target = graph.T_world_keyframe(closure.target);
  Placement placement;
  placement.T_into_world = source_moves ? T_world_target * closure.T_target_source * T_world_source.inverse()
                                        : T_world_source * closure.T_target_source.inverse() * T_world_target.inverse();
  placement.p_world = source_moves ? T_world_source.t : T_world_target.t;
  placement.source_way = graph.odometer(closure.source);
  placement.target_way = graph.odometer(closure.target);
  placement.weight = closure.overlap;
  return placement;
}

bool Worlds::solve(MapGraph before) {
  Stopwatch stopwatch;
  const MapGraph::Solution solution = graph.optimize();
  optimize_ms += stopwatch.lap_ms();
  if (error.empty()) error = solution.error;
  if (!solution.solved || solution.odometry_chi2_per_dof > kMaxOdometryChi2) {
    graph = std::move(before);
    return false;
  }
  take_over_verdicts();
  ++revision;
  return true;
}

void Worlds::take_over_verdicts() {
  const std::vector<graph::Edge>& edges = graph.graph().edges;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!edges[i].robust) continue;
    ClosureState& state = closure(static_cast<int>(edges[i].provenance)).state;
    if (graph.weights()[i] == 0.0) {
      state = ClosureState::kRejected;
    } else if (state == ClosureState::kRejected) {
      state = ClosureState::kCounts;
    }
  }
}

}  // namespace mmlins::mapping

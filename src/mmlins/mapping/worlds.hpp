// SPDX-License-Identifier: MIT
#pragma once
// What the back end knows: where everything lies, and what was found on the way. A world is a set of maps that were joined.

#include <string>
#include <utility>
#include <vector>

#include "mmlins/mapping/closure.hpp"
#include "mmlins/mapping/consistency.hpp"
#include "mmlins/mapping/map_graph.hpp"

namespace mmlins::mapping {

struct Worlds {
  explicit Worlds(MapGraph empty) : graph(std::move(empty)) {}

  MapGraph graph;
  std::vector<Closure> closures;  ///< positions are their ids
  std::vector<Merge> merges;      ///< likewise
  Time now;
  int revision = 0;          ///< rises whenever keyframes have been moved
  double optimize_ms = 0.0;  ///< spent so far
  std::string error;         ///< why the graph could not be optimised, the first time; empty if it always could

  [[nodiscard]] Closure& closure(int id) { return closures[static_cast<std::size_t>(id)]; }
  [[nodiscard]] const Closure& closure(int id) const { return closures[static_cast<std::size_t>(id)]; }
  /// Whether a closure leads from one world to the other, in either direction.
  [[nodiscard]] bool is_between(const Closure& closure, int world_a, int world_b) const;
  /// How the closure places the world that its source is in, or that of its target, in the other.
  [[nodiscard]] Placement placement_of(const Closure& closure, bool source_moves) const;
  /// @return false if the graph is better without what was added since `before`; then it is as it was
  bool solve(MapGraph before);
  /// Closures that the graph rejects are so called, and those that it believes again are not any longer.
  void take_over_verdicts();
};

}  // namespace mmlins::mapping

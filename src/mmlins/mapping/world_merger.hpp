// SPDX-License-Identifier: MIT
#pragma once
// Makes two worlds one when several closures agree on it, and takes that back when it turns out to be wrong.
// docs/math/mapping.md, "Two maps become one".

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/mapping/worlds.hpp"

namespace mmlins::mapping {

class WorldMerger {
 public:
  /// @param worlds  must outlive the merger
  WorldMerger(const MappingConfig& config, Worlds& worlds) : config_(config), worlds_(worlds) {}

  /// Joins two worlds if the closures that wait between them are enough for it.
  /// @return the merge, which has been done and is to be filed
  [[nodiscard]] std::optional<Merge> try_to_merge(int world_a, int world_b);
  /// Merges that have stood so far and put the one end of this closure into the frame of the other.
  [[nodiscard]] std::vector<int> merges_between(const Closure& closure) const;
  /// Whether the merge would be made again, by all that is known now; otherwise it is taken back.
  void review(int merge_id);

 private:
  /// Closures that tell the same story.
  struct Case {
    std::vector<int> closures;  ///< the last look at each two places
    std::vector<int> repeated;  ///< looks at the same places before
    Placement best;       ///< of the one with most overlap
    double weight = 0.0;
    double span = 0.0;    ///< way over which they were found [m]
    bool has_two_targets = false;
  };
  [[nodiscard]] Case strongest_case(const std::vector<int>& closures, const std::vector<Placement>& placements) const;
  /// Looks at the same two places share the weight of one.
  [[nodiscard]] std::vector<Placement> placements_of(const std::vector<int>& closures,
                                                     const std::function<bool(int map)>& moves) const;
  /// Of these, the last look at each two places.
  [[nodiscard]] std::vector<int> last_looks(const std::vector<int>& closures) const;
  [[nodiscard]] bool is_enough(const Case& one, int into, int world) const;
  /// How often a merge of these two was taken back.
  [[nodiscard]] int num_undone(int into, int world) const;
  /// Whether the graph, by gaps too, has the two keyframes about where the closure says.
  [[nodiscard]] bool is_as_predicted(const Closure& closure) const;
  /// Closures of two worlds that lie as `like` has them, but see through each other's walls.
  [[nodiscard]] int num_seen_through(int into, int world, const Placement& like) const;
  [[nodiscard]] bool sees_through(const Closure& closure) const;
  [[nodiscard]] bool commit(Merge& merge);
  void dissolve(int merge_id, const std::string& why);

  MappingConfig config_;
  Worlds& worlds_;
};

}  // namespace mmlins::mapping

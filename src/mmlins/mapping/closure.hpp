// SPDX-License-Identifier: MIT
#pragma once
// What the back end found out, with its evidence.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/math/se3.hpp"

namespace mmlins::mapping {

enum class ClosureOrigin {
  kPredicted,   ///< the graph says that the places are near each other
  kSearched,    ///< it says so roughly, and the surroundings were searched
  kRecognised,  ///< they look alike
};

enum class ClosureState {
  kRefused,    ///< by verification
  kWaiting,    ///< verified, between maps that are not joined (yet)
  kConfirmed,  ///< verified, and what was known already: it changes nothing
  kCounts,     ///< an edge of the graph
  kRejected,   ///< was an edge, until others spoke against it
};

[[nodiscard]] std::string_view to_string(ClosureOrigin origin);
[[nodiscard]] std::string_view to_string(ClosureState state);

/// Two keyframes that stand in the same place, or were thought to.
struct Closure {
  int id = 0;
  int source = 0;  ///< the later keyframe
  int target = 0;
  int source_map = 0;
  int target_map = 0;
  int source_begin = 0;  ///< first keyframe of the submap around each: the same, however far it has grown
  int target_begin = 0;
  Time time;       ///< when it was found: that of the latest keyframe then
  ClosureOrigin origin = ClosureOrigin::kPredicted;
  ClosureState state = ClosureState::kRefused;
  double score = 0.0;  ///< likeness, or share of structure in a search; 0 if predicted
  math::SE3 T_target_source;
  math::Matrix6d information = math::Matrix6d::Zero();  ///< of e in T Exp(e), [rotation; translation]
  double overlap = 0.0;
  double residual_rms = 0.0;  ///< [m]
  double crossing_share = 0.0;  ///< of rays that pass through surfaces of the other
  double moved = 0.0;   ///< from where the graph had it, along what is determined [m]; -1 if it had no idea
  double turned = 0.0;  ///< the same of its rotation [rad]
  double news = 0.0;    ///< above 1 it says something new: it is farther from there than its own deviation explains
  bool contradicts = false;  ///< refused only because two maps that were joined would have to lie elsewhere
  std::string reason;         ///< the verdict in one line
};

/// Two worlds that became one. A world is a set of maps that were joined; its number is that of its first map.
struct Merge {
  int id = 0;  ///< its position
  Time time;
  int world = 0;  ///< that moved
  int into = 0;
  std::vector<int> closures;   ///< ids of those that agree and were the reason
  std::vector<int> enhancing;  ///< ids of those sought and found afterwards
  math::SE3 T_new_old;        ///< what moved its maps, before optimisation
  math::SE3 T_before;         ///< where its first map lay in the world before that
  bool prior_known = false;   ///< whether the IMU had carried the pose from one to the other
  int num_keyframes = 0;      ///< there were when it was done
  std::vector<int> moved_maps;  ///< of the world that moved, at that time
  std::vector<int> into_maps;   ///< of the other
  std::optional<Time> undone;   ///< when it was taken back, if it was
  std::string why_undone;

  /// What users and the atlas call it: from 1 on.
  [[nodiscard]] int number() const { return id + 1; }
};

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#pragma once
// The pose graph as keyframes grow it: links of the odometry, gaps between maps, gravity, closures; and what it says
// about where keyframes lie to each other.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mmlins/graph/optimize.hpp"
#include "mmlins/keyframe/keyframe.hpp"
#include "mmlins/mapping/closure.hpp"
#include "mmlins/mapping/mapping_config.hpp"
#include "mmlins/registration/verify.hpp"

namespace mmlins::mapping {

/// How a map began.
struct MapBegin {
  int map_id = 0;
  math::SE3 T_world_map;  ///< its place by the gaps before it
  /// Of what the IMU carried from the last keyframe of the map before to the first of this one, in T Exp(e). None for
  /// the first map, and where the IMU was silent.
  std::optional<math::Matrix6d> gap_covariance;
};

/// Two keyframes, whose relative pose is of interest.
struct KeyframePair {
  int target = 0;
  int source = 0;
};

class MapGraph {
 public:
  MapGraph(const LinkConfig& link, const graph::OptimizerConfig& optimizer) : link_(link), optimizer_(optimizer) {}

  /// @pre maps come in the order of their ids, which begin at 0
  void begin_map(const MapBegin& begin);
  /// @param pose_covariance  of the pose against its map, in T Exp(e)
  /// @pre keyframes come in the order of their ids, which begin at 0, and belong to the latest map
  void add(const keyframe::Keyframe& keyframe, const math::Matrix6d& pose_covariance);

  /// The IMU alone carries the pose to the next keyframe of this map. docs/math/mapping.md, Eq. (1).
  void bridge(const math::Matrix6d& covariance);

  /// Whether anywhere between two keyframes the IMU alone carried the pose.
  [[nodiscard]] bool is_bridged(int id_a, int id_b) const {
    return num_bridges_[static_cast<std::size_t>(id_a)] != num_bridges_[static_cast<std::size_t>(id_b)];
  }

  [[nodiscard]] int num_maps() const { return static_cast<int>(begins_.size()); }
  [[nodiscard]] int num_keyframes() const { return static_cast<int>(graph_.nodes.size()); }
  [[nodiscard]] math::SE3 T_world_keyframe(int id) const;
  [[nodiscard]] int map_of(int id) const { return graph_.nodes[static_cast<std::size_t>(id)].map; }
  /// Way along the keyframes since the first of all [m]; maps follow each other without a gap.
  [[nodiscard]] double odometer(int id) const { return odometer_[static_cast<std::size_t>(id)]; }
  /// The first map of those that this one has been joined to.
  [[nodiscard]] int world_of(int map) const { return worlds_[static_cast<std::size_t>(map)]; }
  /// Whether anything, be it a gap, says how two maps lie to each other.
  [[nodiscard]] bool are_connected(int map_a, int map_b) const;

  /// What the graph knows of relative poses; none where nothing leads from one to the other.
  [[nodiscard]] std::vector<std::optional<registration::PosePrior>> predict(std::span<const KeyframePair> pairs) const;

  /// Moves all maps of a world: the placement T_other_world replaces what gaps said.
  void move_world(int world, const math::SE3& T_new_old);
  /// From now on two worlds are one.
  void join(int world, int into);
  [[nodiscard]] const math::SE3& T_world_map(int map) const { return graph_.anchors[static_cast<std::size_t>(map)].T_world_map; }
  /// Takes maps out of their world again, with all closures that tied them to it: they lie where gaps say, or so that the
  /// first of them lies at T_world_first. To be optimised afterwards.
  void separate(std::span<const int> maps, const math::SE3& T_world_first);
  /// Adds a closure as an edge.
  void add_closure(const Closure& closure);
  /// Holds two keyframes where they lie to each other now, as well as a closure that confirms it knows, and a `least`
  /// covariance.
  void hold(const Closure& closure, const math::Matrix6d& least);
  /// If it could not be solved, all is as before. Closures that the graph rejects have no weight then.
  struct Solution {
    bool solved = false;
    std::string error;  ///< why not
    double odometry_chi2_per_dof = 0.0;
  };
  [[nodiscard]] Solution optimize();
  /// Squared normalised distance of each of these closures from what all others say; -1 if nothing else does.
  [[nodiscard]] std::vector<double> test(std::span<const int> closure_ids) const;

  [[nodiscard]] const graph::PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const std::vector<double>& weights() const { return weights_; }

 private:
  void connect_again();
  void add_gravity(const keyframe::Keyframe& keyframe, bool is_first);

  LinkConfig link_;
  graph::OptimizerConfig optimizer_;
  graph::PoseGraph graph_;
  std::vector<double> weights_;   ///< of the edges; 0: rejected
  int num_since_gravity_ = 0;     ///< keyframes of the stretch that the latest gravity factor stands for
  std::vector<double> odometer_;
  std::vector<int> num_bridges_;  ///< up to each keyframe
  std::vector<int> worlds_;       ///< of each map
  std::vector<int> gap_islands_;  ///< of each map: the first one that gaps lead to
  std::vector<int> islands_;      ///< of each map: the first one that it is connected to
  std::vector<MapBegin> begins_;
  math::SE3 T_map_last_;          ///< the last keyframe as the odometry had it
  std::optional<math::Matrix6d> bridge_;  ///< from the last keyframe to the next one, if the IMU alone carries the pose
  std::optional<math::Matrix6d> gap_;  ///< from the last keyframe to the latest map, while that has none
};

/// Of a pose known to so much in all directions.
[[nodiscard]] math::Matrix6d covariance_of(double rotation_deg, double position);

/// Covariance of what the odometry says between two keyframes. docs/math/mapping.md, Eq. (1).
[[nodiscard]] math::Matrix6d link_covariance(const math::SE3& T_from_to, const math::Matrix6d& pose_covariance,
                                             const LinkConfig& config);

}  // namespace mmlins::mapping

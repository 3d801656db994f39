// SPDX-License-Identifier: MIT
#include "mmlins/mapping/map_graph.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numbers>
#include <utility>

#include "mmlins/base/check.hpp"
#include "mmlins/graph/relative_covariance.hpp"
#include "mmlins/registration/edge_information.hpp"

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;

constexpr double kRad = std::numbers::pi / 180.0;

Matrix6d inverse_of(const Matrix6d& covariance) { return covariance.ldlt().solve(Matrix6d::Identity()); }

void replace_all(std::vector<int>& values, int from, int to) { std::replace(values.begin(), values.end(), from, to); }

}  // namespace

Matrix6d covariance_of(double rotation_deg, double position) {
  math::Vector6d deviations;
  deviations << math::Vector3d::Constant(kRad * rotation_deg), math::Vector3d::Constant(position);
  return deviations.cwiseAbs2().asDiagonal();
}

Matrix6d link_covariance(const SE3& T_from_to, const Matrix6d& pose_covariance, const LinkConfig& config) {
  const double travel = T_from_to.t.norm();
  const double position = config.position + config.position_per_m * travel;
  const double rotation = kRad * (config.rotation_deg + config.rotation_deg_per_m * travel);
  Matrix6d covariance = travel / config.weak_length * pose_covariance;
  covariance.diagonal().head<3>().array() += rotation * rotation;
  covariance.diagonal().tail<3>().array() += position * position;
  return covariance;
}

void MapGraph::begin_map(const MapBegin& begin) {
  MMLINS_CHECK(begin.map_id == static_cast<int>(begins_.size()));
  // A map that saw nothing leaves two gaps in a row.
  const bool follows_keyframe = begin.map_id > 0 && !graph_.nodes.empty() && graph_.nodes.back().map == begin.map_id - 1;
  if (follows_keyframe) {
    gap_ = begin.gap_covariance;
  } else if (gap_) {
    gap_ = begin.gap_covariance ? std::optional<Matrix6d>(*gap_ + *begin.gap_covariance) : std::nullopt;
  }
  bridge_.reset();
  begins_.push_back(begin);
  worlds_.push_back(begin.map_id);
  islands_.push_back(begin.map_id);
  gap_islands_.push_back(begin.map_id);
  if (gap_) {
    const auto before = static_cast<std::size_t>(graph_.nodes.back().map);
    islands_.back() = islands_[before];
    gap_islands_.back() = gap_islands_[before];
  }
  SE3 T_world_map = begin.T_world_map;
  if (!graph_.nodes.empty()) {
    // Where the map before has been moved since, this one goes along.
    const SE3 T_first_last = begins_[static_cast<std::size_t>(graph_.nodes.back().map)].T_world_map * T_map_last_;
    T_world_map = T_world_keyframe(num_keyframes() - 1) * (T_first_last.inverse() * begin.T_world_map);
  }
  graph_.anchors.push_back({begin.map_id, T_world_map, begin.map_id == 0});
}

void MapGraph::add(const keyframe::Keyframe& keyframe, const Matrix6d& pose_covariance) {
  MMLINS_CHECK(keyframe.id == num_keyframes() && keyframe.map_id + 1 == static_cast<int>(begins_.size()));
  const bool is_first = graph_.nodes.empty() || graph_.nodes.back().map != keyframe.map_id;
  SE3 T_map_node = keyframe.T_map_imu;
  // Where the keyframe before has been moved within its map, this one goes along.
  if (!is_first) T_map_node = graph_.nodes.back().T_map_node * (T_map_last_.inverse() * keyframe.T_map_imu);
  graph_.nodes.push_back({keyframe.id, keyframe.map_id, T_map_node, false});
  add_gravity(keyframe, is_first);
  double travel = 0.0;
  if (!is_first) {
    const SE3 T_last_this = T_map_last_.inverse() * keyframe.T_map_imu;
    travel = T_last_this.t.norm();
    Matrix6d covariance = link_covariance(T_last_this, pose_covariance, link_);
    if (bridge_) covariance += link_.gap_factor * link_.gap_factor * *bridge_;
    graph_.edges.push_back({keyframe.id - 1, keyframe.id, T_last_this, inverse_of(covariance)});
    weights_.push_back(1.0);
  } else if (gap_) {
    const SE3 T_first_last = begins_[static_cast<std::size_t>(map_of(keyframe.id - 1))].T_world_map * T_map_last_;
    graph_.edges.push_back({keyframe.id - 1, keyframe.id,
                            T_first_last.inverse() * begins_.back().T_world_map * keyframe.T_map_imu,
                            inverse_of(link_.gap_factor * link_.gap_factor * *gap_), graph::EdgeKind::kGap});
    weights_.push_back(1.0);
  }
  num_bridges_.push_back((num_bridges_.empty() ? 0 : num_bridges_.back()) + (bridge_ ? 1 : 0));
  bridge_.reset();
  odometer_.push_back((odometer_.empty() ? 0.0 : odometer_.back()) + travel);
  T_map_last_ = keyframe.T_map_imu;
}

void MapGraph::bridge(const Matrix6d& covariance) { bridge_ = bridge_ ? Matrix6d(*bridge_ + covariance) : covariance; }

void MapGraph::add_gravity(const keyframe::Keyframe& keyframe, bool is_first) {
  if (link_.gravity_every == 0) return;
  // What gravity is taken for changes slowly: many factors would be one error many times. The latest of a stretch knows best.
  num_since_gravity_ = is_first ? 0 : (num_since_gravity_ + 1) % link_.gravity_every;
  if (num_since_gravity_ != 0) graph_.gravity.pop_back();
  graph_.gravity.push_back({keyframe.id, -keyframe.down_imu, kRad * link_.gravity_deg});
}

SE3 MapGraph::T_world_keyframe(int id) const {
  const graph::Node& node = graph_.nodes[static_cast<std::size_t>(id)];
  return graph_.anchors[static_cast<std::size_t>(node.map)].T_world_map * node.T_map_node;
}

bool MapGraph::are_connected(int map_a, int map_b) const {
  return islands_[static_cast<std::size_t>(map_a)] == islands_[static_cast<std::size_t>(map_b)];
}

std::vector<std::optional<registration::PosePrior>> MapGraph::predict(std::span<const KeyframePair> pairs) const {
  std::vector<std::optional<registration::PosePrior>> priors(pairs.size());
  std::vector<graph::NodePair> asked;
  for (const KeyframePair& pair : pairs) asked.push_back({pair.target, pair.source});
  const auto known = graph::relative_covariances(graph_, asked, weights_);
  if (!known) return priors;  // nor can the graph be optimised then, which is told
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const graph::RelativeCovariance& one = (*known)[i];
    if (one.status == graph::CovarianceStatus::kKnown) priors[i] = registration::PosePrior{one.T_i_j, one.covariance};
  }
  return priors;
}

void MapGraph::move_world(int world, const SE3& T_new_old) {
  for (graph::Anchor& anchor : graph_.anchors) {
    if (world_of(anchor.map) == world) anchor.T_world_map = T_new_old * anchor.T_world_map;
  }
}

void MapGraph::join(int world, int into) {
  replace_all(worlds_, world, into);
  const int island = islands_[static_cast<std::size_t>(into)], other = islands_[static_cast<std::size_t>(world)];
  replace_all(islands_, std::max(island, other), std::min(island, other));
}

void MapGraph::separate(std::span<const int> maps, const SE3& T_world_first) {
  const auto is_out = [&](int map) { return std::find(maps.begin(), maps.end(), map) != maps.end(); };
  SE3 T_back = T_world_first * T_world_map(maps.front()).inverse();
  bool by_gap = false;
  std::vector<graph::Edge> edges;
  std::vector<double> weights;
  for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
    const graph::Edge& edge = graph_.edges[i];
    const bool from_out = is_out(map_of(static_cast<int>(edge.from))), to_out = is_out(map_of(static_cast<int>(edge.to)));
    if (from_out != to_out && edge.robust) continue;
    edges.push_back(edge);
    weights.push_back(weights_[i]);
    // Maps that come after them follow them, and not they those.
    if (from_out || !to_out || std::exchange(by_gap, true)) continue;
    T_back = T_world_keyframe(static_cast<int>(edge.from)) * edge.T_from_to * T_world_keyframe(static_cast<int>(edge.to)).inverse();
  }
  graph_.edges = std::move(edges);
  weights_ = std::move(weights);
  const int world = world_of(maps.front());
  int first_in = -1, first_out = -1;
  for (std::size_t map = 0; map < worlds_.size(); ++map) {
    if (worlds_[map] != world) continue;
    int& first = is_out(static_cast<int>(map)) ? first_out : first_in;
    if (first < 0) first = static_cast<int>(map);
    worlds_[map] = first;  // no later map is compared with this one
  }
  for (graph::Anchor& anchor : graph_.anchors) {
    if (is_out(anchor.map)) anchor.T_world_map = T_back * anchor.T_world_map;
  }
  connect_again();
}

void MapGraph::connect_again() {
  islands_ = gap_islands_;
  for (std::size_t map = 0; map < worlds_.size(); ++map) {
    const int a = islands_[map], b = islands_[static_cast<std::size_t>(worlds_[map])];
    replace_all(islands_, std::max(a, b), std::min(a, b));
  }
}

void MapGraph::add_closure(const Closure& closure) {
  const bool same_map = closure.source_map == closure.target_map;
  graph_.edges.push_back({closure.target, closure.source, closure.T_target_source, closure.information,
                          same_map ? graph::EdgeKind::kLoop : graph::EdgeKind::kMerge, true, closure.id});
  weights_.push_back(1.0);
}

void MapGraph::hold(const Closure& closure, const Matrix6d& least) {
  Closure held = closure;
  held.T_target_source = T_world_keyframe(closure.target).inverse() * T_world_keyframe(closure.source);
  held.information = registration::compared_information(closure.information, least);
  add_closure(held);
}

MapGraph::Solution MapGraph::optimize() {
  Solution solution;
  auto optimized = graph::optimize(graph_, optimizer_);
  if (!optimized || optimized->report.status == graph::GraphStatus::kSolverFailed) {
    solution.error = optimized ? "the solver failed" : optimized.error().message;
    return solution;
  }
  solution.solved = true;
  graph_ = std::move(optimized->graph);
  const graph::GraphReport& report = optimized->report;
  for (std::size_t i = 0; i < report.edges.size(); ++i) weights_[i] = report.edges[i].weight;
  constexpr auto kOdometry = static_cast<std::size_t>(graph::EdgeKind::kOdometry);
  const int num_links = report.num_of_kind[kOdometry];
  if (num_links > 0) solution.odometry_chi2_per_dof = report.final.of_kind[kOdometry] / (6.0 * num_links);
  return solution;
}

std::vector<double> MapGraph::test(std::span<const int> closure_ids) const {
  std::vector<std::size_t> edges;
  for (const int id : closure_ids) {
    const auto is_it = [&](const graph::Edge& edge) { return edge.robust && edge.provenance == id; };
    const auto found = std::find_if(graph_.edges.begin(), graph_.edges.end(), is_it);
    MMLINS_CHECK(found != graph_.edges.end());
    edges.push_back(static_cast<std::size_t>(found - graph_.edges.begin()));
  }
  std::vector<double> chi2(closure_ids.size(), -1.0);
  const auto tests = graph::test_edges(graph_, edges, weights_);
  if (!tests) return chi2;
  for (std::size_t i = 0; i < chi2.size(); ++i) {
    if ((*tests)[i].rank > 0) chi2[i] = (*tests)[i].chi2;
  }
  return chi2;
}

}  // namespace mmlins::mapping

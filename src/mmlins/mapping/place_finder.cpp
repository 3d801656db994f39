// SPDX-License-Identifier: MIT
#include "mmlins/mapping/place_finder.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/base/stopwatch.hpp"

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;
using registration::PosePrior;

constexpr double kRad = std::numbers::pi / 180.0;
/// Predictions looked at more closely, nearest first.
constexpr std::size_t kMaxPredicted = 6;

/// The same knowledge about the frames of two submaps instead of those of their keyframes.
PosePrior of_submaps(const PosePrior& prior, const SubmapRecord& target, const SubmapRecord& source) {
  PosePrior out;
  out.T_target_source = target.T_keyframe_submap.inverse() * prior.T_target_source * source.T_keyframe_submap;
  Matrix6d turn = Matrix6d::Zero();
  const math::Matrix3d R_submap_keyframe = source.T_keyframe_submap.R.transpose();
  turn.topLeftCorner<3, 3>() = R_submap_keyframe;
  turn.bottomRightCorner<3, 3>() = R_submap_keyframe;
  out.covariance = turn * prior.covariance * turn.transpose();
  return out;
}

double largest_deviation(const math::Matrix3d& covariance) {
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<math::Matrix3d>(covariance).eigenvalues()(2)));
}

double position_deviation(const PosePrior& prior) { return largest_deviation(prior.covariance.bottomRightCorner<3, 3>()); }
double rotation_deviation(const PosePrior& prior) { return largest_deviation(prior.covariance.topLeftCorner<3, 3>()); }

}  // namespace

PlaceFinder::PlaceFinder(const MappingConfig& config, const MapGraph& graph, SubmapLibrary& library)
    : config_(config), graph_(graph), library_(library), places_(config.place) {}

place::PlaceDescriptor PlaceFinder::describe(const keyframe::Submap& submap) {
  Stopwatch stopwatch;
  place::PlaceDescriptor descriptor = place::make_descriptor(submap, config_.place);
  times_.describe_ms += stopwatch.lap_ms();
  return descriptor;
}

void PlaceFinder::add(const SubmapRecord& record, place::PlaceDescriptor descriptor) {
  places_.add({record.map_id, record.id}, std::move(descriptor));
}

bool PlaceFinder::may_be_met_again(const SubmapRecord& source, const SubmapRecord& target) const {
  if (source.map_id != target.map_id) return true;
  return graph_.odometer(source.first_keyframe) - graph_.odometer(target.last_keyframe) >= config_.loop.min_travel;
}

std::vector<PlaceCandidate> PlaceFinder::predicted(const SubmapRecord& source, const keyframe::Submap& submap) {
  const SE3 T_world_source = graph_.T_world_keyframe(source.id);
  std::vector<std::pair<double, std::size_t>> nearest;
  const std::vector<SubmapRecord>& records = library_.records();
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (!graph_.are_connected(records[i].map_id, source.map_id) || !may_be_met_again(source, records[i])) continue;
    const double distance = (graph_.T_world_keyframe(records[i].id).t - T_world_source.t).norm();
    const double near = std::max(config_.loop.near, config_.loop.near_between_maps);
    if (distance < near + 2.0 * config_.loop.search) nearest.emplace_back(distance, i);
  }
  std::sort(nearest.begin(), nearest.end());
  if (nearest.size() > kMaxPredicted) nearest.resize(kMaxPredicted);
  std::vector<KeyframePair> pairs;
  for (const auto& [distance, index] : nearest) pairs.push_back({records[index].id, source.id});
  if (pairs.empty()) return {};
  const auto priors = graph_.predict(pairs);
  std::vector<PlaceCandidate> candidates;
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    if (static_cast<int>(candidates.size()) >= config_.loop.num_predicted) break;
    if (!priors[k]) continue;
    const PosePrior prior = of_submaps(*priors[k], records[nearest[k].second], source);
    const bool is_joined = graph_.world_of(source.map_id) == graph_.world_of(records[nearest[k].second].map_id);
    const double near = is_joined ? config_.loop.near : config_.loop.near_between_maps;
    if (nearest[k].first > near + 2.0 * position_deviation(prior)) continue;
    if (auto candidate = around(source, submap, nearest[k].second, prior)) candidates.push_back(std::move(*candidate));
  }
  return candidates;
}

std::optional<PlaceCandidate> PlaceFinder::around(const SubmapRecord& source, const keyframe::Submap& submap,
                                                  std::size_t index, const PosePrior& prior) {
  PlaceCandidate candidate{index, ClosureOrigin::kPredicted, 0.0, {prior.T_target_source}, prior};
  const double position = position_deviation(prior), rotation = rotation_deviation(prior);
  if (position <= config_.loop.direct && rotation <= kRad * config_.loop.direct_deg) return candidate;
  if (3.0 * position > config_.loop.search && graph_.world_of(source.map_id) == graph_.world_of(library_.records()[index].map_id)) {
    return std::nullopt;  // odometry alone leads there over a long way: looks find it better
  }
  const auto target = library_.load(index);
  if (!target) {
    log::warning("{}", target.error().message);
    return std::nullopt;
  }
  Stopwatch stopwatch;
  const double reach = std::clamp(3.0 * position, config_.search.apart, config_.loop.search);
  const registration::SearchRegion region{reach, reach, std::clamp(3.0 * rotation, 0.05, std::numbers::pi),
                                          std::clamp(3.0 * std::sqrt(prior.covariance(5, 5)), 0.5, 2.5)};
  candidate.origin = ClosureOrigin::kSearched;
  candidate.starts.clear();
  for (const registration::Start& start :
       registration::search_around(submap, (*target)->submap, prior.T_target_source, region, config_.search)) {
    candidate.starts.push_back(start.T_target_source);
    candidate.score = std::max(candidate.score, start.score);
  }
  times_.search_ms += stopwatch.lap_ms();
  if (candidate.starts.empty()) return std::nullopt;
  // Where it lies already must not fit as well.
  if (graph_.world_of(source.map_id) == graph_.world_of(library_.records()[index].map_id)) {
    candidate.starts.push_back(prior.T_target_source);
  }
  return candidate;
}

std::vector<PlaceCandidate> PlaceFinder::recognised(const SubmapRecord& source, const place::PlaceDescriptor& descriptor) {
  Stopwatch stopwatch;
  const auto is_eligible = [&](const place::PlaceId& id) {
    return may_be_met_again(source, library_.records()[index_of(id.submap_id)]);
  };
  const auto found = places_.query(descriptor, static_cast<std::size_t>(config_.loop.num_recognised), is_eligible);
  times_.query_ms += stopwatch.lap_ms();
  std::vector<PlaceCandidate> candidates;
  std::vector<KeyframePair> pairs;
  for (const place::Candidate& one : found) {
    if (one.score < config_.loop.min_score) continue;
    const std::size_t index = index_of(one.id.submap_id);
    candidates.push_back({index, ClosureOrigin::kRecognised, one.score, {one.T_place_query}, std::nullopt});
    pairs.push_back({library_.records()[index].id, source.id});
  }
  if (pairs.empty()) return candidates;
  const auto priors = graph_.predict(pairs);
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (priors[k]) candidates[k].prior = of_submaps(*priors[k], library_.records()[candidates[k].index], source);
  }
  return candidates;
}

std::size_t PlaceFinder::index_of(int submap_id) const {
  const std::vector<SubmapRecord>& records = library_.records();
  const auto found = std::lower_bound(records.begin(), records.end(), submap_id,
                                      [](const SubmapRecord& record, int id) { return record.id < id; });
  MMLINS_CHECK(found != records.end() && found->id == submap_id);
  return static_cast<std::size_t>(found - records.begin());
}

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/submap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/base/check.hpp"
#include "mmlins/math/grid.hpp"
#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::keyframe {

namespace {

using math::SE3;
using math::Vector3d;

/// Up in the frame of the map as all keyframes feel it: their errors average out.
Vector3d mean_up(std::span<const KeyframePointer> keyframes) {
  Vector3d sum = Vector3d::Zero();
  for (const KeyframePointer& kf : keyframes) sum -= kf->T_map_imu.R * kf->down_imu;
  return sum.norm() > 0.0 ? sum.normalized() : Vector3d::UnitZ();
}

SE3 levelled_frame(const SE3& T_map_imu, const Vector3d& up_map) {
  Vector3d forward = T_map_imu.R.col(0);
  // An IMU whose x axis is upright has a heading by its y axis only.
  if (std::abs(forward.dot(up_map)) > 0.95) forward = T_map_imu.R.col(1).cross(up_map);
  const Vector3d x = (forward - forward.dot(up_map) * up_map).normalized();
  SE3 T_map_submap;
  T_map_submap.R << x, up_map.cross(x), up_map;
  T_map_submap.t = T_map_imu.t;
  return T_map_submap;
}

/// The keyframe that is nearest to half of the way.
std::size_t middle_of(std::span<const KeyframePointer> keyframes, double travel) {
  double travelled = 0.0;
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    const double step = (keyframes[i]->T_map_imu.t - keyframes[i - 1]->T_map_imu.t).norm();
    if (travelled + 0.5 * step >= 0.5 * travel) return i - 1;
    travelled += step;
  }
  return keyframes.size() - 1;
}

double travel_of(std::span<const KeyframePointer> keyframes) {
  double travel = 0.0;
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    travel += (keyframes[i]->T_map_imu.t - keyframes[i - 1]->T_map_imu.t).norm();
  }
  return travel;
}

/// Mean of the points of each voxel, in the order in which voxels were first seen.
class VoxelMeans {
 public:
  explicit VoxelMeans(double voxel) : inverse_voxel_(1.0 / voxel), cells_(voxel) {}

  void add(const Vector3d& p, std::uint16_t view) {
    Cell& cell = cells_.payloads()[cells_.find_or_add(math::cell_at<double>(p, inverse_voxel_))];
    if (cell.count == 0) cell.view = view;
    cell.sum += p;
    ++cell.count;
  }

  void write(Submap& submap) const {
    submap.points.reserve(cells_.payloads().size());
    submap.views.reserve(cells_.payloads().size());
    for (const Cell& cell : cells_.payloads()) {
      submap.points.push_back((cell.sum / cell.count).cast<float>());
      submap.views.push_back(cell.view);
    }
  }

 private:
  struct Cell {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    std::uint16_t view = 0;
  };
  double inverse_voxel_;
  spatial::VoxelTable<Cell> cells_;
};

}  // namespace

Fields SubmapConfig::fields() {
  return {
      field("travel", travel, "m", {1.0, 200.0}, "way travelled within one submap"),
      field("max_turn_deg", max_turn_deg, "deg", {30.0, 36000.0},
            "turning on the spot that ends a submap as well"),
      field("voxel", voxel, "m", {0.05, 2.0}, "one point is kept in each cube of this edge"),
      field("radius", radius, "m", {5.0, 300.0}, "points farther from the middle of the submap are left out"),
  };
}

Submap build_submap(std::span<const KeyframePointer> keyframes, const SubmapConfig& config) {
  MMLINS_CHECK(!keyframes.empty());
  Submap submap;
  submap.travel = travel_of(keyframes);
  const Keyframe& middle = *keyframes[middle_of(keyframes, submap.travel)];
  submap.id = middle.id;
  submap.map_id = middle.map_id;
  submap.time = middle.time;
  submap.T_map_submap = levelled_frame(middle.T_map_imu, mean_up(keyframes));
  const SE3 T_submap_map = submap.T_map_submap.inverse();
  VoxelMeans voxels(config.voxel);
  for (const KeyframePointer& kf : keyframes) {
    const SE3 T_submap_imu = T_submap_map * kf->T_map_imu;
    const auto view = static_cast<std::uint16_t>(std::min<std::size_t>(submap.viewpoints.size(), 65535));
    submap.keyframe_ids.push_back(kf->id);
    submap.viewpoints.push_back(T_submap_imu.t.cast<float>());
    for (const Eigen::Vector3f& p_imu : kf->points_imu) {
      const Vector3d p = T_submap_imu * p_imu.cast<double>();
      if (p.squaredNorm() < config.radius * config.radius) voxels.add(p, view);
    }
  }
  voxels.write(submap);
  return submap;
}

std::vector<KeyframeRange> split_by_travel(std::span<const KeyframePointer> keyframes,
                                           const SubmapConfig& config) {
  const double max_turn = config.max_turn_deg * std::numbers::pi / 180.0;
  std::vector<KeyframeRange> ranges;
  std::size_t first = 0;
  while (first < keyframes.size()) {
    double travel = 0.0, turn = 0.0;
    std::size_t half = first + 1, last = first + 1;
    const auto same_map = [&] { return keyframes[last]->map_id == keyframes[first]->map_id; };
    for (; last < keyframes.size() && same_map() && travel < config.travel && turn < max_turn; ++last) {
      travel += (keyframes[last]->T_map_imu.t - keyframes[last - 1]->T_map_imu.t).norm();
      turn += turn_between(keyframes[last - 1]->T_map_imu, keyframes[last]->T_map_imu);
      if (travel < 0.5 * config.travel && turn < 0.5 * max_turn) half = last + 1;
    }
    ranges.push_back({first, last});
    const bool map_ends = last == keyframes.size() || !same_map();
    first = map_ends ? last : half;
  }
  return ranges;
}

}  // namespace mmlins::keyframe

// SPDX-License-Identifier: MIT
#include "mmlins/registration/fit_height.hpp"

#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "mmlins/math/grid.hpp"

namespace mmlins::registration {

namespace {

using math::Vector3d;

constexpr double kCell = 0.5;   // [m]
constexpr double kStep = 0.25;  // between the heights that are tried [m]
constexpr std::size_t kMaxPoints = 3000;
constexpr int kStandingCells = 3;  // a column with at least as many occupied cells stands
constexpr int kStandingWeight = 4;

std::uint64_t key_of(const Vector3d& p) { return math::cell_key(math::cell_at<double>(p, 1.0 / kCell)); }

struct WeightedPoint {
  Vector3d p;
  int weight;
};

/// The first point of each cell, some of them, weighted by whether their columns stand.
std::vector<WeightedPoint> weighted_points(const keyframe::Submap& submap) {
  std::unordered_set<std::uint64_t> taken;
  std::unordered_map<std::uint64_t, int> columns;
  std::vector<Vector3d> points;
  const auto column_of = [](const Vector3d& p) { return key_of({p.x(), p.y(), 0.0}); };
  for (const Eigen::Vector3f& point : submap.points) {
    const Vector3d p = point.cast<double>();
    if (!taken.insert(key_of(p)).second) continue;
    points.push_back(p);
    ++columns[column_of(p)];
  }
  std::vector<WeightedPoint> some;
  const std::size_t count = std::min(kMaxPoints, points.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3d& p = points[k * points.size() / count];
    some.push_back({p, columns[column_of(p)] >= kStandingCells ? kStandingWeight : 1});
  }
  return some;
}

}  // namespace

math::SE3 fit_height(const keyframe::Submap& source, const keyframe::Submap& target,
                     const math::SE3& T_target_source, double range) {
  std::unordered_set<std::uint64_t> occupied;
  for (const Eigen::Vector3f& p : target.points) occupied.insert(key_of(p.cast<double>()));
  const std::vector<WeightedPoint> points = weighted_points(source);
  math::SE3 best = T_target_source;
  int most = -1;
  const int steps = static_cast<int>(std::floor(range / kStep));
  for (int n = 0; n <= 2 * steps; ++n) {  // 0, +1, -1, +2, ...: the nearest first
    const int k = n % 2 == 1 ? (n + 1) / 2 : -n / 2;
    math::SE3 T = T_target_source;
    T.t.z() += k * kStep;
    int sum = 0;
    for (const WeightedPoint& point : points)
      sum += occupied.contains(key_of(T * point.p)) ? point.weight : 0;
    if (sum <= most) continue;
    most = sum;
    best = T;
  }
  return best;
}

}  // namespace mmlins::registration

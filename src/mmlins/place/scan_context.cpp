// SPDX-License-Identifier: MIT
#include "mmlins/place/scan_context.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mmlins::place {

namespace {

/// Shift of the candidate's sectors that brings its key nearest to the query's.
int align_keys(const Eigen::VectorXf& query, const Eigen::VectorXf& candidate) {
  const Eigen::Index n = query.size();
  int best = 0;
  float least = std::numeric_limits<float>::infinity();
  for (Eigen::Index shift = 0; shift < n; ++shift) {
    float sum = 0.0F;
    for (Eigen::Index j = 0; j < n; ++j) {
      const float d = query(j) - candidate((j + shift) % n);
      sum += d * d;
    }
    if (sum < least) {
      least = sum;
      best = static_cast<int>(shift);
    }
  }
  return best;
}

/// The paper's distance at one shift. A sector that is empty in one of them has nothing in common; one that
/// is empty in both says nothing.
double distance_at(const ScanContext& query, const ScanContext& candidate, Eigen::Index shift) {
  const Eigen::Index n = query.heights.cols();
  double similarity = 0.0;
  int num_compared = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto a = query.heights.col(j);
    const auto b = candidate.heights.col((j + shift) % n);
    const double norm_a = static_cast<double>(a.norm()), norm_b = static_cast<double>(b.norm());
    if (norm_a == 0.0 && norm_b == 0.0) continue;
    ++num_compared;
    if (norm_a > 0.0 && norm_b > 0.0) similarity += static_cast<double>(a.dot(b)) / (norm_a * norm_b);
  }
  return num_compared > 0 ? 1.0 - similarity / num_compared : 1.0;
}

}  // namespace

Fields ScanContextConfig::fields() {
  return {
      field("num_rings", num_rings, "", {4.0, 200.0}, "divisions of the range"),
      field("num_sectors", num_sectors, "", {8.0, 720.0}, "divisions of the circle"),
      field("max_range", max_range, "m", {5.0, 300.0}, "points farther away are left out"),
      field("sensor_height", sensor_height, "m", {0.0, 10.0},
            "above the ground, so that heights are positive"),
      field("search_share", search_share, "", {0.0, 1.0},
            "of the circle, tried around the heading of the sector keys"),
  };
}

ScanContext make_scan_context(std::span<const Eigen::Vector3f> points, const ScanContextConfig& config) {
  ScanContext context;
  context.heights = Eigen::MatrixXf::Zero(config.num_rings, config.num_sectors);
  for (const Eigen::Vector3f& p : points) {
    const double range = std::hypot(static_cast<double>(p.x()), static_cast<double>(p.y()));
    if (range >= config.max_range) continue;
    const double turn =
        std::atan2(static_cast<double>(p.y()), static_cast<double>(p.x())) / (2.0 * std::numbers::pi);
    const int ring = static_cast<int>(range / config.max_range * config.num_rings);
    const int sector =
        static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * config.num_sectors) % config.num_sectors;
    float& height = context.heights(ring, sector);
    height = std::max(height, p.z() + static_cast<float>(config.sensor_height));
  }
  context.ring_key = (context.heights.array() > 0.0F).cast<float>().rowwise().mean();
  context.sector_key = context.heights.colwise().mean().transpose();
  return context;
}

ContextMatch compare(const ScanContext& query, const ScanContext& candidate,
                     const ScanContextConfig& config) {
  const int n = static_cast<int>(query.heights.cols());
  const int middle = align_keys(query.sector_key, candidate.sector_key);
  const int reach = std::min(n / 2, static_cast<int>(std::ceil(0.5 * config.search_share * n)));
  ContextMatch best{.distance = 2.0};
  for (int k = -reach; k <= reach; ++k) {
    const int shift = ((middle + k) % n + n) % n;
    const double distance = distance_at(query, candidate, shift);
    // What the query sees in sector j the candidate sees in sector j + shift.
    const double turn = shift > n / 2 ? shift - n : shift;
    if (distance < best.distance) best = {distance, turn * 2.0 * std::numbers::pi / n};
  }
  return best;
}

}  // namespace mmlins::place

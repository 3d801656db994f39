// SPDX-License-Identifier: MIT
#include "mmlins/mapping/consistency.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace mmlins::mapping {
namespace {

constexpr std::size_t kMaxPlacements = 30;
/// More way than this allows for no more difference [m]: who closes a loop has gone far and is near again.
constexpr double kLongestWay = 30.0;

/// Grows cliques one member at a time, members in rising order.
class CliqueSearch {
 public:
  CliqueSearch(const std::vector<std::uint32_t>& neighbours, std::span<const Placement> placements)
      : neighbours_(neighbours), placements_(placements) {}

  std::uint32_t run() {
    grow(0, static_cast<std::uint32_t>((std::uint64_t{1} << placements_.size()) - 1), 0.0);
    return best_;
  }

 private:
  void grow(std::uint32_t members, std::uint32_t candidates, double weight) {
    if (weight > best_weight_) {
      best_weight_ = weight;
      best_ = members;
    }
    if (weight + weight_of(candidates) <= best_weight_) return;
    while (candidates != 0) {
      const int next = std::countr_zero(candidates);
      candidates &= candidates - 1;
      const auto at = static_cast<std::size_t>(next);
      grow(members | 1U << next, candidates & neighbours_[at], weight + placements_[at].weight);
    }
  }

  [[nodiscard]] double weight_of(std::uint32_t set) const {
    double sum = 0.0;
    for (; set != 0; set &= set - 1) sum += placements_[static_cast<std::size_t>(std::countr_zero(set))].weight;
    return sum;
  }

  const std::vector<std::uint32_t>& neighbours_;
  std::span<const Placement> placements_;
  std::uint32_t best_ = 0;
  double best_weight_ = 0.0;
};

}  // namespace

bool agree(const Placement& a, const Placement& b, const MergeConfig& config) {
  const double way = std::min(std::abs(a.source_way - b.source_way) + std::abs(a.target_way - b.target_way), kLongestWay);
  const math::Vector3d p = 0.5 * (a.p_world + b.p_world);
  const double apart = (a.T_into_world * p - b.T_into_world * p).norm();
  const double turned = math::so3_log((a.T_into_world.R.transpose() * b.T_into_world.R).eval()).norm();
  return apart <= config.agree_within + config.agree_within_per_m * way &&
         turned * 180.0 / std::numbers::pi <= config.agree_within_deg + config.agree_within_deg_per_m * way;
}

std::vector<std::size_t> largest_agreement(std::span<const Placement> placements, const MergeConfig& config) {
  const std::size_t skipped = placements.size() - std::min(placements.size(), kMaxPlacements);
  const std::span<const Placement> looked_at = placements.subspan(skipped);
  std::vector<std::uint32_t> neighbours(looked_at.size(), 0);
  for (std::size_t i = 0; i < looked_at.size(); ++i) {
    for (std::size_t j = 0; j < looked_at.size(); ++j) {
      if (i != j && agree(looked_at[i], looked_at[j], config)) neighbours[i] |= 1U << j;
    }
  }
  const std::uint32_t best = CliqueSearch(neighbours, looked_at).run();
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < looked_at.size(); ++i) {
    if ((best >> i & 1U) != 0) members.push_back(i + skipped);
  }
  return members;
}

}  // namespace mmlins::mapping

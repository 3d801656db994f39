// SPDX-License-Identifier: MIT
#pragma once
// The reference: point-to-point ICP (Besl and McKay, PAMI 1992), as the MM-LINS paper has it. The back end as
// it is by default registers by surfaces instead (registration/).

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "mmlins/mapping/paper_config.hpp"
#include "mmlins/math/se3.hpp"

namespace mmlins::mapping {

/// Finds the nearest of a set of points.
class NearestPoint {
 public:
  explicit NearestPoint(std::vector<Eigen::Vector3f> points);

  struct Found {
    Eigen::Vector3f point = Eigen::Vector3f::Zero();
    float distance2 = 0.0F;  ///< squared [m^2]; infinite if there are no points
  };
  [[nodiscard]] Found find(const Eigen::Vector3f& query) const;

 private:
  void split(std::size_t first, std::size_t last);
  void search(std::size_t first, std::size_t last, const Eigen::Vector3f& query, Found& best) const;

  std::vector<Eigen::Vector3f> points_;  ///< a k-d tree: the middle of each range splits it
  std::vector<std::uint8_t> axes_;       ///< along which axis, for each point
};

struct IcpResult {
  math::SE3 T_target_source;
  double fitness =
      0.0;  ///< mean squared distance of all source points from their nearest target points [m^2]
  int iterations = 0;
  bool converged = false;  ///< false: it was still moving, or had no pairs to move by
};

/// @param T_target_source  the guess
[[nodiscard]] IcpResult register_points(std::span<const Eigen::Vector3f> source, const NearestPoint& target,
                                        const math::SE3& T_target_source, const IcpConfig& config);

}  // namespace mmlins::mapping

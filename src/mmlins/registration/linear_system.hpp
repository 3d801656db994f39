// SPDX-License-Identifier: MIT
#pragma once
// The residuals of one registration at one pose, and their quadratic form.

#include <cstdint>
#include <optional>
#include <span>

#include "mmlins/degeneracy/observability.hpp"
#include "mmlins/registration/gaussian_map.hpp"

namespace mmlins::registration {

/// How samples are matched in one stage.
struct Matching {
  const GaussianMap* map = nullptr;
  const GaussianMap* fallback = nullptr;  ///< for points where `map` has no surface; may be null
  double reach = 0.5;                     ///< in cells
  double kernel = 1.0;                    ///< of Geman and McClure [m]
  double point_variance = 0.0;            ///< [m^2]
};

/// One matched sample. Rows are for T [+] xi = T Exp(xi), tangent [rotation; translation].
struct Residual {
  int num_rows = 0;
  Eigen::Vector2d error = Eigen::Vector2d::Zero();     ///< across the surface [m]
  Eigen::Vector2d variance = Eigen::Vector2d::Ones();  ///< [m^2]
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor> J = Eigen::Matrix<double, 2, 6, Eigen::RowMajor>::Zero();
  double weight = 0.0;  ///< of the robust kernel
  const SurfaceCell* cell = nullptr;
};

struct LinearSystem {
  math::Matrix6d H = math::Matrix6d::Zero();
  math::Vector6d b = math::Vector6d::Zero();
  int num_matched = 0;

  LinearSystem& operator+=(const LinearSystem& other);
};

/// The surface that a point in the target's frame belongs to; none within reach.
[[nodiscard]] std::optional<SurfaceMatch> find_surface(const math::Vector3d& p_target,
                                                       const Matching& matching);
[[nodiscard]] std::optional<Residual> residual_of(const math::Vector3d& p_source,
                                                  const math::SE3& T_target_source, const Matching& matching);

/// Sum over all samples; the same bits whatever the number of threads.
[[nodiscard]] LinearSystem linearise(std::span<const math::Vector3d> samples,
                                     const math::SE3& T_target_source, const Matching& matching);

/// What noisy normals add to H for one residual, on average (docs/math/degeneracy.md, Eqs. (4) and (5)).
[[nodiscard]] math::Matrix6d spurious_information(const Residual& residual, const math::Vector3d& p_source,
                                                  const math::SE3& T_target_source);

}  // namespace mmlins::registration

// SPDX-License-Identifier: MIT
#pragma once
// Which of the six directions of a pose a scan determines, and how well: in metres and radians, and as the
// share that the noise of the normals alone would feign. Free of units, point counts and sensor types.
// docs/math/degeneracy.md.

#include <array>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/math/se3.hpp"

namespace mmlins::degeneracy {

struct ObservabilityConfig {
  double weak_position = 0.05;
  double weak_rotation_deg = 0.2;
  double weak_noise_share = 0.1;

  [[nodiscard]] Fields fields();
};

/// The pose information of one scan, tangent order [rotation; translation], at the origin of the body.
struct ScanInformation {
  math::Matrix6d H = math::Matrix6d::Zero();         ///< sum of w J^T J
  math::Matrix6d spurious = math::Matrix6d::Zero();  ///< what noisy normals alone contribute to H on average

  ScanInformation& operator+=(const ScanInformation& other);
};

/// One principal direction.
struct Direction {
  math::Vector3d axis = math::Vector3d::UnitX();  ///< unit, in the frame of its block of the tangent
  double std = 0.0;          ///< standard deviation with all else free [m] or [rad]; infinite if nothing is left
  double noise_share = 0.0;  ///< share of its information that noisy normals feign: near 1 is no information
  bool weak = false;
};

/// Three directions of each block, the weakest first.
struct Observability {
  std::array<Direction, 3> rotation;
  std::array<Direction, 3> translation;

  [[nodiscard]] int num_weak() const;
};

/// Splits the information into its marginal principal directions: each block is reduced by its Schur
/// complement, so that rotation and translation, which have different units, are judged apart, and a direction
/// that only a rotation could explain is not taken for seen. Eqs. (1)-(4).
[[nodiscard]] Observability analyse_observability(const ScanInformation& information, const ObservabilityConfig& config);

}  // namespace mmlins::degeneracy

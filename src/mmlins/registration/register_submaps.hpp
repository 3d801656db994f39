// SPDX-License-Identifier: MIT
#pragma once
// Where does one submap lie in another? Generalised ICP of points against voxel Gaussians, from large cells
// to small ones; first in x, y, z and yaw, because both submaps are level, then in all six.
// docs/math/registration.md.

#include <vector>

#include "mmlins/degeneracy/observability.hpp"
#include "mmlins/keyframe/submap.hpp"
#include "mmlins/registration/gaussian_map.hpp"

namespace mmlins::registration {

struct RegistrationConfig {
  SurfaceConfig surface;
  degeneracy::ObservabilityConfig observability{
      .weak_position = 0.3, .weak_rotation_deg = 1.0, .weak_noise_share = 0.3};
  double coarse_cell = 2.0;
  int num_levels = 3;
  double sample_spacing = 0.5;
  int max_samples = 4000;
  int max_iterations = 25;
  double coarse_kernel = 1.0;
  double fine_kernel = 0.15;
  double overlap_distance = 0.3;
  double cluster_size = 4.0;
  double min_correlation = 10.0;

  [[nodiscard]] Fields fields();
};

/// A submap made ready to be registered many times, in either role.
struct PreparedSubmap {
  std::vector<GaussianMap> levels;          ///< largest cells first
  std::vector<math::Vector3d> samples;      ///< some of its points [m]
  std::vector<math::Vector3d> viewpoints;   ///< for each sample: where it was seen from [m]
  std::vector<bool> stands;                 ///< for each sample: whether it is no part of a floor or ceiling
  std::vector<math::Vector3d> few_samples;  ///< every n-th of the samples
};
[[nodiscard]] PreparedSubmap prepare(const keyframe::Submap& submap, const RegistrationConfig& config);

enum class RegistrationStatus {
  kConverged,
  kNotConverged,
  kTooFewMatches,
  kHopeless,  ///< given up before the last stage: pose and overlaps are rough, and nothing else is known
};

/// A result with less than this is of no interest.
struct LeastOverlap {
  double all = 0.0;
  double standing = 0.0;
};

struct Registration {
  RegistrationStatus status = RegistrationStatus::kTooFewMatches;
  math::SE3 T_target_source;
  /// Of T_target_source [+] xi = T Exp(xi); what noisy normals feign has been taken out.
  math::Matrix6d information = math::Matrix6d::Zero();
  double overlap = 0.0;           ///< share of the source's samples that lie on a surface of the target
  double standing_overlap = 0.0;  ///< the same of what stands: floors fit upon floors anywhere
  double residual_rms = 0.0;      ///< of the samples on surfaces [m]
  double chi2 = 0.0;              ///< mean of the squared normalised residuals
  double correlation = 1.0;       ///< how many neighbouring residuals are worth one
  degeneracy::Observability observability;  ///< axes in the frame of the source
  int iterations = 0;
};

/// For hopeless results: the distance within which their overlaps are counted, in overlap_distance.
inline constexpr double kHopelessDistance = 1.5;

/// @param T_target_source  the guess; up to about 2 m and 10 degrees off
/// @param least  a result that cannot come to this is given up before the last stage, which is what takes the
/// time
[[nodiscard]] Registration register_submaps(const PreparedSubmap& source, const PreparedSubmap& target,
                                            const math::SE3& T_target_source,
                                            const RegistrationConfig& config, const LeastOverlap& least = {});
[[nodiscard]] Registration register_submaps(const keyframe::Submap& source, const keyframe::Submap& target,
                                            const math::SE3& T_target_source,
                                            const RegistrationConfig& config);

}  // namespace mmlins::registration

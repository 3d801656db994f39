// SPDX-License-Identifier: MIT
#pragma once
// How much a registration is worth as an edge of a graph: never more than its residuals allow, and nothing
// along directions that only noise determines. docs/math/registration.md.

#include <vector>

#include "mmlins/degeneracy/observability.hpp"

namespace mmlins::registration {

/// A motion of all six that one observed or unobserved direction stands for, and the share of its information
/// that is kept.
struct JudgedDirection {
  math::Vector6d motion = math::Vector6d::Zero();
  double share_kept = 1.0;
};

/// The directions of `observability`, lifted to six dimensions by `H`: the other block follows as it likes
/// best.
/// @param weak_noise_share  of ObservabilityConfig: above it next to nothing is kept
[[nodiscard]] std::vector<JudgedDirection> judge_directions(const math::Matrix6d& H,
                                                            const degeneracy::Observability& observability,
                                                            double weak_noise_share);

/// Leaves `share_kept` of the information along the motion, with all else free.
[[nodiscard]] math::Matrix6d reduce_information(const math::Matrix6d& information,
                                                const JudgedDirection& direction);

/// The part of a small motion that the information speaks about: without what lies along directions that are
/// weak.
[[nodiscard]] math::Vector6d observed_part(const math::Vector6d& motion, const math::Matrix6d& H,
                                           const degeneracy::Observability& observability);

/// (covariance + information^-1)^-1, where the information may know nothing of some directions: how well a pose known
/// with one and a pose known with the other can be compared.
[[nodiscard]] math::Matrix6d compared_information(const math::Matrix6d& information,
                                                  const math::Matrix6d& covariance);

}  // namespace mmlins::registration

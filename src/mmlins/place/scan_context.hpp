// SPDX-License-Identifier: MIT
#pragma once
// Scan Context as its paper describes it (Kim and Kim, "Scan Context: Egocentric Spatial Descriptor for Place
// Recognition within 3D Point Cloud Map", IROS 2018): the baseline. The sector key that narrows the search
// for the heading is that of its sequel (Kim, Choi and Kim, T-RO 2021). docs/math/place.md.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mmlins/base/config_fields.hpp"

namespace mmlins::place {

struct ScanContextConfig {
  int num_rings = 20;
  int num_sectors = 60;
  double max_range = 80.0;
  double sensor_height = 2.0;
  double search_share = 0.1;

  [[nodiscard]] Fields fields();
};

struct ScanContext {
  Eigen::MatrixXf heights;   ///< ring x sector: the highest point above the ground; 0 if there is none [m]
  Eigen::VectorXf ring_key;  ///< share of each ring's sectors that hold anything: does not change by turning
  Eigen::VectorXf sector_key;  ///< mean height of each sector
};

[[nodiscard]] ScanContext make_scan_context(std::span<const Eigen::Vector3f> points,
                                            const ScanContextConfig& config);

struct ContextMatch {
  double distance = 1.0;  ///< 0: the same, 1: nothing in common
  double yaw = 0.0;       ///< of the query's frame in the candidate's [rad]
};

/// Mean cosine distance of the sectors, at the best of the shifts near the one that the sector keys suggest.
[[nodiscard]] ContextMatch compare(const ScanContext& query, const ScanContext& candidate,
                                   const ScanContextConfig& config);

}  // namespace mmlins::place

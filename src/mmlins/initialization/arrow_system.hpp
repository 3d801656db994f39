// SPDX-License-Identifier: MIT
#pragma once
// Normal equations of a chain of nodes that also share some unknowns: block-tridiagonal with a border.
// Eliminated from the first node on, so that what remains at the end is the information about the last node
// and the shared unknowns, everything else marginalised. docs/math/initialization.md, Eq. (14).

#include <Eigen/Core>
#include <vector>

namespace mmlins::initialization {

inline constexpr int kNodeSize = 9;
inline constexpr int kMaxShared = 9;

using NodeMatrix = Eigen::Matrix<double, kNodeSize, kNodeSize>;
using NodeVector = Eigen::Matrix<double, kNodeSize, 1>;
using BorderMatrix = Eigen::Matrix<double, kNodeSize, Eigen::Dynamic, 0, kNodeSize, kMaxShared>;
using SharedMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxShared, kMaxShared>;
using SharedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxShared, 1>;

/// H x = b, for the x that lessens the cost.
struct ArrowSystem {
  ArrowSystem(std::size_t num_nodes, int num_shared);

  std::vector<NodeMatrix> diagonal;
  std::vector<NodeMatrix> next;      ///< coupling of node k (rows) with k + 1 (columns); one fewer than nodes
  std::vector<BorderMatrix> border;  ///< coupling of node k with the shared unknowns
  std::vector<NodeVector> b;
  SharedMatrix shared;
  SharedVector b_shared;
};

struct ArrowSolution {
  bool ok = false;  ///< false: singular, or not finite
  std::vector<NodeVector> nodes;
  SharedVector shared;
  Eigen::MatrixXd last_covariance;  ///< of [last node, shared]
};

[[nodiscard]] ArrowSolution solve(ArrowSystem system);

/// The same system in fewer shared unknowns: old = T new.
[[nodiscard]] ArrowSystem with_shared(const ArrowSystem& system, const Eigen::MatrixXd& T);

}  // namespace mmlins::initialization

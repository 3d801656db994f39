// SPDX-License-Identifier: MIT
#include "mmlins/graph/relative_covariance.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <unordered_map>

#include "mmlins/graph/graph_index.hpp"

namespace mmlins::graph {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Basis = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;
using Eigen::MatrixXd;

/// A pivot smaller than this share of its diagonal entry means a direction that nothing determines.
constexpr double kSingular = 1e-11;
/// An edge whose own share of what is known in a direction leaves less than this to others is its only
/// witness.
constexpr double kOnlyWitness = 1e-8;

/// Where the unknowns of each node stand in the normal equations, and which steps they are.
struct Unknowns {
  std::vector<int> offset;
  std::vector<Basis> basis;  ///< columns are steps [rotation; translation]
  int size = 0;
};

Unknowns list_unknowns(const Parts& parts, const std::vector<SE3>& poses) {
  Unknowns unknowns;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Basis basis(6, 0);
    if (parts.freedom[i] == Freedom::kFree) basis = Matrix6d::Identity();
    if (parts.freedom[i] == Freedom::kTiltOnly) {
      basis = Basis::Zero(6, 2);
      basis.topRows<3>() = poses[i].R.transpose().leftCols<2>();
    }
    unknowns.offset.push_back(unknowns.size);
    unknowns.size += static_cast<int>(basis.cols());
    unknowns.basis.push_back(std::move(basis));
  }
  return unknowns;
}

class NormalMatrix {
 public:
  explicit NormalMatrix(const Unknowns& unknowns) : unknowns_(unknowns) {}

  /// Adds J_a^T J_b in the lower triangle.
  void add(int a, const MatrixXd& J_a, int b, const MatrixXd& J_b) {
    const MatrixXd block = (J_a * unknowns_.basis[static_cast<std::size_t>(a)]).transpose() *
                           (J_b * unknowns_.basis[static_cast<std::size_t>(b)]);
    for (int row = 0; row < block.rows(); ++row) {
      for (int column = 0; column < block.cols(); ++column) {
        const int i = unknowns_.offset[static_cast<std::size_t>(a)] + row;
        const int j = unknowns_.offset[static_cast<std::size_t>(b)] + column;
        if (i >= j) entries_.emplace_back(i, j, block(row, column));
      }
    }
  }

  Sparse matrix() const {
    Sparse H(unknowns_.size, unknowns_.size);
    H.setFromTriplets(entries_.begin(), entries_.end());
    return H;
  }

 private:
  const Unknowns& unknowns_;
  std::vector<Eigen::Triplet<double>> entries_;
};

Sparse normal_matrix(const PoseGraph& graph, const GraphIndex& index, const std::vector<SE3>& poses,
                     const std::vector<double>& weights, const Unknowns& unknowns) {
  NormalMatrix normal(unknowns);
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (weights[e] < 0.5 || index.roots[e].rank == 0) continue;
    const auto [from, to] = index.ends[e];
    const EdgeError error = linearize_edge(poses[static_cast<std::size_t>(from)],
                                           poses[static_cast<std::size_t>(to)], graph.edges[e].T_from_to);
    const Matrix6d J_from = index.roots[e].S * error.J_from;
    const Matrix6d J_to = index.roots[e].S * error.J_to;
    normal.add(from, J_from, from, J_from);
    normal.add(to, J_to, to, J_to);
    normal.add(from, J_from, to, J_to);
    normal.add(to, J_to, from, J_from);
  }
  for (std::size_t g = 0; g < graph.gravity.size(); ++g) {
    const int node = index.node_of_gravity[g];
    const SE3& T_world_node = poses[static_cast<std::size_t>(node)];
    MatrixXd J = MatrixXd::Zero(3, 6);
    J.leftCols<3>() =
        linearize_gravity(T_world_node.R, graph.gravity[g].up_node).J_rotation / graph.gravity[g].sigma;
    normal.add(node, J, node, J);
  }
  return normal.matrix();
}

/// The factorised graph.
class CovarianceSolver {
 public:
  CovarianceSolver(const PoseGraph& graph, const GraphIndex& index, const std::vector<double>& weights)
      : graph_(graph),
        index_(index),
        weights_(weights),
        parts_(find_parts(graph, index, weights)),
        poses_(world_poses(graph, index)),
        unknowns_(list_unknowns(parts_, poses_)),
        H_(normal_matrix(graph, index, poses_, weights, unknowns_)) {
    if (unknowns_.size == 0) return;
    cholesky_.compute(H_);
    regular_ = cholesky_.info() == Eigen::Success;
    if (!regular_) return;
    const Eigen::VectorXd diagonal = cholesky_.permutationP() * Eigen::VectorXd(H_.diagonal());
    const Eigen::VectorXd pivots = cholesky_.vectorD();
    regular_ = (pivots.array() > kSingular * diagonal.array()).all();
  }

  RelativeCovariance between(int i, int j) const {
    RelativeCovariance result;
    result.T_i_j = pose(i).inverse() * pose(j);
    if (parts_.part_of_node[static_cast<std::size_t>(i)] !=
        parts_.part_of_node[static_cast<std::size_t>(j)]) {
      result.status = CovarianceStatus::kUnconnected;
      return result;
    }
    if (!regular_) return result;
    result.status = CovarianceStatus::kKnown;
    if (i == j || unknowns_.size == 0) return result;
    // A step of i is seen from j through the adjoint.
    MatrixXd J = MatrixXd::Zero(unknowns_.size, 6);
    place(i, -math::adjoint(result.T_i_j.inverse()), J);
    place(j, Matrix6d::Identity(), J);
    result.covariance = covariance_of(J);
    return result;
  }

  EdgeTest test(std::size_t e) const {
    const auto [from, to] = index_.ends[e];
    EdgeTest result;
    result.status = status_between(from, to);
    if (result.status != CovarianceStatus::kKnown) return result;
    const Matrix6d& S = index_.roots[e].S;
    const EdgeError error = linearize_edge(pose(from), pose(to), graph_.edges[e].T_from_to);
    MatrixXd J = MatrixXd::Zero(unknowns_.size, 6);
    place(from, S * error.J_from, J);
    place(to, S * error.J_to, J);
    // Believed edges have pulled the rest towards them; candidates have not.
    const bool counts = weights_[e] >= 0.5;
    const Matrix6d spread = unknowns_.size > 0 ? covariance_of(J) : Matrix6d(Matrix6d::Zero());
    const Matrix6d M =
        counts ? Matrix6d(Matrix6d::Identity() - spread) : Matrix6d(Matrix6d::Identity() + spread);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(M);
    const Vector6d r = eigen.eigenvectors().transpose() * S * error.e;
    result.rank = index_.roots[e].rank;
    for (int k = 0; k < 6; ++k) {
      if (eigen.eigenvalues()(k) < kOnlyWitness) {
        --result.rank;
      } else {
        result.chi2 += r(k) * r(k) / eigen.eigenvalues()(k);
      }
    }
    return result;
  }

 private:
  CovarianceStatus status_between(int i, int j) const {
    const bool joined =
        parts_.part_of_node[static_cast<std::size_t>(i)] == parts_.part_of_node[static_cast<std::size_t>(j)];
    if (!joined) return CovarianceStatus::kUnconnected;
    return regular_ ? CovarianceStatus::kKnown : CovarianceStatus::kUndetermined;
  }
  /// J^T H^-1 J
  Matrix6d covariance_of(const MatrixXd& J) const {
    const Matrix6d covariance = J.transpose() * cholesky_.solve(J);
    return 0.5 * (covariance + covariance.transpose());
  }
  const SE3& pose(int node) const { return poses_[static_cast<std::size_t>(node)]; }
  void place(int node, const Matrix6d& J_node, MatrixXd& J) const {
    const Basis& basis = unknowns_.basis[static_cast<std::size_t>(node)];
    J.middleRows(unknowns_.offset[static_cast<std::size_t>(node)], basis.cols()) +=
        (J_node * basis).transpose();
  }

  const PoseGraph& graph_;
  const GraphIndex& index_;
  const std::vector<double>& weights_;
  Parts parts_;
  std::vector<SE3> poses_;
  Unknowns unknowns_;
  Sparse H_;
  Eigen::SimplicialLDLT<Sparse> cholesky_;
  bool regular_ = true;
};

std::vector<double> weights_or_ones(const PoseGraph& graph, const std::vector<double>& weights) {
  MMLINS_CHECK(weights.empty() || weights.size() == graph.edges.size());
  return weights.empty() ? std::vector<double>(graph.edges.size(), 1.0) : weights;
}

}  // namespace

Result<std::vector<RelativeCovariance>> relative_covariances(const PoseGraph& graph,
                                                             const std::vector<NodePair>& pairs,
                                                             const std::vector<double>& weights) {
  const Result<GraphIndex> index = index_graph(graph);
  if (!index) return index.error();
  std::unordered_map<std::int64_t, int> position;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i)
    position.emplace(graph.nodes[i].id, static_cast<int>(i));
  for (const NodePair& pair : pairs) {
    for (const std::int64_t id : {pair.i, pair.j}) {
      if (position.count(id) == 0) {
        return make_error(ErrorCode::kNotFound,
                          "pose graph: there is no node {}; its covariance cannot be told", id);
      }
    }
  }
  const std::vector<double> all_weights = weights_or_ones(graph, weights);
  const CovarianceSolver solver(graph, *index, all_weights);
  std::vector<RelativeCovariance> all;
  for (const NodePair& pair : pairs) all.push_back(solver.between(position.at(pair.i), position.at(pair.j)));
  return all;
}

Result<std::vector<EdgeTest>> test_edges(const PoseGraph& graph, const std::vector<std::size_t>& edges,
                                         const std::vector<double>& weights) {
  const Result<GraphIndex> index = index_graph(graph);
  if (!index) return index.error();
  const std::vector<double> all_weights = weights_or_ones(graph, weights);
  const CovarianceSolver solver(graph, *index, all_weights);
  std::vector<EdgeTest> all;
  for (const std::size_t e : edges) {
    MMLINS_CHECK(e < graph.edges.size());
    all.push_back(solver.test(e));
  }
  return all;
}

Result<RelativeCovariance> relative_covariance(const PoseGraph& graph, std::int64_t i, std::int64_t j,
                                               const std::vector<double>& weights) {
  const auto all = relative_covariances(graph, {{i, j}}, weights);
  if (!all) return all.error();
  return all->front();
}

}  // namespace mmlins::graph

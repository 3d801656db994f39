// SPDX-License-Identifier: MIT
#include "mmlins/graph/graph_problem.hpp"

namespace mmlins::graph {
namespace {

ceres::Problem::Options problem_options() {
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

/// One thread and a factorisation without BLAS: the bits depend on nothing but the input.
ceres::Solver::Options solver_options(const SolveLimits& limits) {
  ceres::Solver::Options options;
  options.max_num_iterations = limits.max_iterations;
  options.function_tolerance = limits.tolerance;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-14;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  // Chains bend slowly under damping, and the start is good or GNC would not have let it pass: begin as
  // Gauss-Newton.
  options.initial_trust_region_radius = 1e8;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

GraphProblem::GraphProblem(const PoseGraph& graph, const GraphIndex& index, const Parts& parts,
                           const std::vector<SE3>& T_world_node, double gap_cauchy)
    : problem_(std::make_unique<ceres::Problem>(problem_options())) {
  blocks_.reserve(T_world_node.size());
  for (const SE3& T : T_world_node) blocks_.push_back(to_block(T));
  add_nodes(parts);
  add_edges(graph, index, gap_cauchy);
}

void GraphProblem::add_nodes(const Parts& parts) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const bool tilt_only = parts.freedom[i] == Freedom::kTiltOnly;
    ceres::Manifold* manifold = tilt_only ? static_cast<ceres::Manifold*>(&tilt_manifold_) : &pose_manifold_;
    problem_->AddParameterBlock(blocks_[i].data(), 7, manifold);
    if (parts.freedom[i] == Freedom::kHeld) problem_->SetParameterBlockConstant(blocks_[i].data());
  }
}

void GraphProblem::add_edges(const PoseGraph& graph, const GraphIndex& index, double gap_cauchy) {
  if (gap_cauchy > 0.0) gap_loss_ = std::make_unique<ceres::CauchyLoss>(gap_cauchy);
  weight_losses_.resize(graph.edges.size());
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    if (index.roots[e].rank == 0) continue;
    ceres::LossFunction* loss = nullptr;
    if (is_robust(edge)) loss = &weight_losses_[e];
    if (edge.kind == EdgeKind::kGap) loss = gap_loss_.get();
    double* from = blocks_[static_cast<std::size_t>(index.ends[e].from)].data();
    double* to = blocks_[static_cast<std::size_t>(index.ends[e].to)].data();
    problem_->AddResidualBlock(new EdgeCost(edge.T_from_to, index.roots[e].S), loss, from, to);
  }
  for (std::size_t g = 0; g < graph.gravity.size(); ++g) {
    double* node = blocks_[static_cast<std::size_t>(index.node_of_gravity[g])].data();
    problem_->AddResidualBlock(new GravityCost(graph.gravity[g].up_node, graph.gravity[g].sigma), nullptr,
                               node);
  }
}

void GraphProblem::set_weights(const std::vector<double>& weights) {
  for (std::size_t e = 0; e < weights.size(); ++e) weight_losses_[e].set_weight(weights[e]);
}

SolveOutcome GraphProblem::solve(const SolveLimits& limits) {
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(limits), problem_.get(), &summary);
  SolveOutcome outcome;
  outcome.iterations = static_cast<int>(summary.iterations.size()) - 1;
  if (outcome.iterations < 0) outcome.iterations = 0;
  outcome.converged = summary.termination_type == ceres::CONVERGENCE;
  outcome.usable = summary.IsSolutionUsable();
  return outcome;
}

std::vector<SE3> GraphProblem::poses() const {
  std::vector<SE3> poses;
  poses.reserve(blocks_.size());
  for (const PoseBlock& block : blocks_) poses.push_back(from_block(block.data()));
  return poses;
}

}  // namespace mmlins::graph

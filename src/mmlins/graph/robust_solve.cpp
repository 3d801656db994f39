// SPDX-License-Identifier: MIT
#include "mmlins/graph/robust_solve.hpp"

#include <algorithm>

#include "mmlins/graph/gnc.hpp"
#include "mmlins/graph/graph_problem.hpp"

namespace mmlins::graph {
namespace {

constexpr int kMaxCorrections = 10;   ///< of the decisions, once the weights have parted
constexpr int kFirstIterations = 10;  ///< while false edges bend the graph it does not pay to go to the end
constexpr double kGncTolerance = 1e-3;

/// chi2 / limit of robust edges; 0 for all others.
std::vector<double> outlier_ratios(const PoseGraph& graph, const GraphIndex& index,
                                   const std::vector<SE3>& poses, double outlier_scale) {
  std::vector<double> ratios = edge_chi2(graph, index, poses);
  for (std::size_t e = 0; e < ratios.size(); ++e) {
    const int rank = index.roots[e].rank;
    ratios[e] = is_robust(graph.edges[e]) && rank > 0 ? ratios[e] / (outlier_scale * chi2_limit(rank)) : 0.0;
  }
  return ratios;
}

std::vector<double> decided_weights(const std::vector<double>& ratios) {
  std::vector<double> weights;
  weights.reserve(ratios.size());
  for (const double ratio : ratios) weights.push_back(ratio <= 1.0 ? 1.0 : 0.0);
  return weights;
}

void add(const SolveOutcome& outcome, RobustSolution& solution) {
  solution.iterations += outcome.iterations;
  solution.converged = outcome.converged;
  solution.usable = solution.usable && outcome.usable;
}

/// Lets the weights of `problem` part into 0 and 1. @return the last ratios
std::vector<double> graduate(const PoseGraph& graph, const GraphIndex& index, const OptimizerConfig& config,
                             GraphProblem& problem, std::vector<double> ratios, RobustSolution& solution) {
  double width = first_width(*std::max_element(ratios.begin(), ratios.end()));
  std::vector<double> weights(ratios.size(), 1.0);
  while (solution.gnc_rounds < config.gnc_rounds && solution.usable) {
    for (std::size_t e = 0; e < ratios.size(); ++e) weights[e] = graduated_weight(ratios[e], width);
    problem.set_weights(weights);
    add(problem.solve({config.gnc_iterations, kGncTolerance}), solution);
    ratios = outlier_ratios(graph, index, problem.poses(), config.outlier_scale);
    ++solution.gnc_rounds;
    if (width <= 1.0) break;
    width = std::max(1.0, width / config.gnc_step);
  }
  return ratios;
}

/// Solves with the edges that are believed, and reconsiders, until nothing changes.
void settle(const PoseGraph& graph, const GraphIndex& index, const OptimizerConfig& config,
            std::vector<double> ratios, RobustSolution& solution) {
  for (int i = 0; i < kMaxCorrections && solution.usable; ++i) {
    solution.weights = decided_weights(ratios);
    solution.parts = find_parts(graph, index, solution.weights);
    GraphProblem problem(graph, index, solution.parts, solution.T_world_node, config.gap_cauchy);
    problem.set_weights(solution.weights);
    add(problem.solve({config.max_iterations, config.tolerance}), solution);
    solution.T_world_node = problem.poses();
    ratios = outlier_ratios(graph, index, solution.T_world_node, config.outlier_scale);
    if (decided_weights(ratios) == solution.weights) return;
  }
}

}  // namespace

std::vector<double> edge_chi2(const PoseGraph& graph, const GraphIndex& index,
                              const std::vector<SE3>& T_world_node) {
  std::vector<double> all;
  all.reserve(graph.edges.size());
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const SE3& T_world_from = T_world_node[static_cast<std::size_t>(index.ends[e].from)];
    const SE3& T_world_to = T_world_node[static_cast<std::size_t>(index.ends[e].to)];
    const Vector6d error = edge_error(T_world_from, T_world_to, graph.edges[e].T_from_to);
    all.push_back((index.roots[e].S * error).squaredNorm());
  }
  return all;
}

RobustSolution solve_robustly(const PoseGraph& graph, const GraphIndex& index, std::vector<SE3> start,
                              const OptimizerConfig& config) {
  RobustSolution solution;
  solution.weights.assign(graph.edges.size(), 1.0);
  solution.parts = find_parts(graph, index, solution.weights);
  GraphProblem problem(graph, index, solution.parts, start, config.gap_cauchy);
  const int first_iterations =
      config.robust ? std::min(kFirstIterations, config.max_iterations) : config.max_iterations;
  add(problem.solve({first_iterations, config.tolerance}), solution);
  std::vector<double> ratios = outlier_ratios(graph, index, problem.poses(), config.outlier_scale);
  const bool all_true = ratios.empty() || *std::max_element(ratios.begin(), ratios.end()) <= 1.0;
  if (!config.robust || all_true) {
    const int left = config.max_iterations - solution.iterations;
    if (!solution.converged && left > 0) add(problem.solve({left, config.tolerance}), solution);
    solution.T_world_node = problem.poses();
    return solution;
  }
  ratios = graduate(graph, index, config, problem, std::move(ratios), solution);
  solution.T_world_node = problem.poses();
  settle(graph, index, config, std::move(ratios), solution);
  return solution;
}

}  // namespace mmlins::graph

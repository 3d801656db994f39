// SPDX-License-Identifier: MIT
// Optimisation of pose graphs: laps with a loop every ten nodes, clean and with false loops, the covariance
// of a candidate, and any g2o file: bench_graph [FILE.g2o ...]

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "mmlins/base/stopwatch.hpp"
#include "mmlins/graph/g2o.hpp"
#include "mmlins/graph/relative_covariance.hpp"
#include "tests/graph/chains.hpp"

namespace mmlins::graph {
namespace {

Chain laps(int num_nodes) {
  return make_chain({.num_nodes = num_nodes, .nodes_per_lap = 500, .loop_every = 10});
}

void count(const GraphReport& report, benchmark::State& state) {
  state.counters["edges"] = static_cast<double>(report.edges.size());
  state.counters["iterations"] = report.iterations;
  state.counters["chi2_first"] = report.initial.total;
  state.counters["chi2_last"] = report.final.total;
  state.counters["chi2_per_dof"] = report.chi2_per_dof();
  state.counters["rejected"] = report.num_rejected;
}

void optimize_laps(benchmark::State& state) {
  const Chain chain = laps(static_cast<int>(state.range(0)));
  GraphReport report;
  for (auto _ : state) report = optimize(chain.graph).value().report;
  count(report, state);
}
BENCHMARK(optimize_laps)->Arg(3000)->Arg(10000)->Unit(benchmark::kMillisecond);

void optimize_with_false_loops(benchmark::State& state) {
  Chain chain = laps(static_cast<int>(state.range(0)));
  math::Random random(5);
  const auto num_nodes = static_cast<double>(state.range(0));
  for (int i = 0; i < state.range(1); ++i) {
    Edge edge = chain.graph.edges.back();
    edge.from = static_cast<std::int64_t>(random.uniform(0.0, 0.5 * num_nodes));
    edge.to = static_cast<std::int64_t>(random.uniform(0.5 * num_nodes + 1.0, num_nodes));
    edge.T_from_to = {math::so3_exp({0.0, 0.0, random.uniform(-3.0, 3.0)}), 2.0 * random.normal3()};
    chain.graph.edges.push_back(edge);
  }
  GraphReport report;
  for (auto _ : state) report = optimize(chain.graph).value().report;
  count(report, state);
}
BENCHMARK(optimize_with_false_loops)->Args({3000, 1})->Args({3000, 30})->Unit(benchmark::kMillisecond);

void covariance(benchmark::State& state) {
  const Chain chain = laps(static_cast<int>(state.range(0)));
  const std::int64_t last = state.range(0) - 1;
  for (auto _ : state) benchmark::DoNotOptimize(relative_covariance(chain.graph, 100, last).value());
}
BENCHMARK(covariance)->Arg(3000)->Arg(10000)->Unit(benchmark::kMillisecond);

/// @return false if the file cannot be read
bool optimize_file(const std::string& path) {
  const Result<PoseGraph> graph = read_g2o(path);
  if (!graph) {
    fmt::print(stderr, "{}\n", graph.error().message);
    return false;
  }
  Stopwatch watch;
  const Result<OptimizedGraph> result = optimize(*graph);
  const double ms = watch.lap_ms();
  if (!result) {
    fmt::print(stderr, "{}: {}\n", path, result.error().message);
    return false;
  }
  const GraphReport& report = result->report;
  fmt::print("{}: {} nodes, {} edges, chi2 {:.6g} -> {:.6g} ({} rejected), {} iterations, {:.3f} s, {}\n",
             path, graph->nodes.size(), graph->edges.size(), report.initial.total, report.final.total,
             report.num_rejected, report.iterations, 1e-3 * ms,
             report.status == GraphStatus::kConverged ? "converged" : "not converged");
  return true;
}

}  // namespace
}  // namespace mmlins::graph

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    if (!mmlins::graph::optimize_file(argv[i])) return 1;
  }
  if (argc < 2) benchmark::RunSpecifiedBenchmarks();
  return 0;
}

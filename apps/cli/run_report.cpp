// SPDX-License-Identifier: MIT
#include "run_report.hpp"

#include "mmlins/base/log.hpp"
#include "mmlins/eval/trajectory_file.hpp"

namespace mmlins::cli {
namespace {

void print_errors(const report::TruthComparison& truth) {
  const auto print = [](const char* name, const eval::Evaluation& e) {
    fmt::print("{}: ATE {:.4f} m (max {:.4f} m), attitude {:.3f} deg\n", name, e.absolute.translation.rmse,
               e.absolute.translation.max, e.absolute.rotation.rmse);
  };
  print("trajectory.tum against the truth", truth.trajectory);
  print("odometry.tum against the truth  ", truth.odometry);
}

}  // namespace

Result<math::Trajectory> read_truth(const std::string& file) {
  if (file.empty()) return math::Trajectory{};
  auto truth = eval::read_tum(file);
  if (!truth) return truth.error();
  if (truth->num_out_of_order > 0) log::warning("{}: {} rows out of order, sorted", file, truth->num_out_of_order);
  if (truth->num_duplicates > 0) log::warning("{}: {} rows with a stamp that was there before, ignored", file, truth->num_duplicates);
  return std::move(truth->poses);
}

Status write_report(const std::string& folder, report::ReportInput input, const math::Trajectory& truth,
                    const std::string& truth_file) {
  std::optional<report::TruthComparison> comparison;
  if (!truth.empty()) {
    auto compared = report::compare_with_truth(input.result, truth, truth_file);
    if (compared) {
      comparison = std::move(*compared);
      input.truth = &*comparison;
      print_errors(*comparison);
    } else {
      log::warning("{}; the report is without it", compared.error().message);
    }
  }
  return report::write_report(folder + "/report.html", input);
}

}  // namespace mmlins::cli

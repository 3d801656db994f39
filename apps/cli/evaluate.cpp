// SPDX-License-Identifier: MIT
// mmlins evaluate: figures of an estimate against the truth, as text or JSON.

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "mmlins/eval/evaluation.hpp"
#include "mmlins/eval/trajectory_file.hpp"

namespace mmlins::cli {
namespace {

struct EvaluateOptions {
  std::string truth;
  std::string estimate;
  std::string alignment = "se3";
  bool json = false;
};

const std::map<std::string, eval::Alignment> kAlignments{
    {"se3", eval::Alignment::kSe3}, {"yaw", eval::Alignment::kYaw}, {"none", eval::Alignment::kNone}};

nlohmann::ordered_json to_json(const eval::Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"max", s.max},   {"std", s.std},   {"count", s.count}};
}

nlohmann::ordered_json to_json(const std::optional<eval::ErrorFigures>& figures, const char* translation,
                               const char* rotation) {
  if (!figures) return nullptr;
  return {{translation, to_json(figures->translation)}, {rotation, to_json(figures->rotation)}};
}

void print_json(const eval::Evaluation& e) {
  const Eigen::Quaterniond q = e.T_truth_estimate.quaternion();
  const math::Vector3d& p = e.T_truth_estimate.t;
  const nlohmann::ordered_json report{
      {"poses", {{"truth", e.num_truth}, {"estimate", e.num_estimate}, {"matched", e.num_matched}}},
      {"duration_s", e.duration},
      {"path_length_m", e.path_length},
      {"alignment",
       {{"p_truth_estimate", {p.x(), p.y(), p.z()}},
        {"q_truth_estimate_xyzw", {q.x(), q.y(), q.z(), q.w()}}}},
      {"ate_m", to_json(e.absolute.translation)},
      {"rotation_deg", to_json(e.absolute.rotation)},
      {"rpe_1s", to_json(e.per_second, "translation_m", "rotation_deg")},
      {"rpe_100m", to_json(e.per_100m, "translation_percent", "rotation_deg_per_100m")},
      {"end_to_end",
       {{"translation_m", e.end_to_end.translation}, {"rotation_deg", e.end_to_end.rotation_deg}}},
      {"coverage",
       {{"share", e.coverage.share},
        {"longest_gap_s", e.coverage.longest_gap},
        {"late_start_s", e.coverage.late_start},
        {"early_end_s", e.coverage.early_end}}}};
  fmt::print("{}\n", report.dump(2));
}

void print_row(const std::string& name, const eval::Statistics& s) {
  fmt::print("{:<28}{:>11.4f}{:>11.4f}{:>11.4f}{:>11.4f}{:>11.4f}\n", name, s.rmse, s.mean, s.median, s.max,
             s.std);
}

void print_text(const eval::Evaluation& e) {
  fmt::print("{:<28}{} of {} estimated ({} true)\n", "matched poses", e.num_matched, e.num_estimate,
             e.num_truth);
  fmt::print("{:<28}{:.2f} s, {:.2f} m\n", "duration, path", e.duration, e.path_length);
  fmt::print("{:<28}{:.2f} %, longest gap {:.3f} s, starts {:.3f} s late, ends {:.3f} s early\n\n",
             "coverage", 100.0 * e.coverage.share, e.coverage.longest_gap, e.coverage.late_start,
             e.coverage.early_end);
  fmt::print("{:<28}{:>11}{:>11}{:>11}{:>11}{:>11}\n", "", "RMSE", "mean", "median", "max", "std");
  print_row("ATE [m]", e.absolute.translation);
  print_row("rotation error [deg]", e.absolute.rotation);
  if (e.per_second) {
    print_row("RPE over 1 s [m]", e.per_second->translation);
    print_row("RPE over 1 s [deg]", e.per_second->rotation);
  } else {
    fmt::print("{:<28}not available: no two poses about 1 s apart\n", "RPE over 1 s");
  }
  if (e.per_100m) {
    print_row("RPE per 100 m [%]", e.per_100m->translation);
    print_row("RPE per 100 m [deg]", e.per_100m->rotation);
  } else {
    fmt::print("{:<28}not available: the path is shorter\n", "RPE per 100 m");
  }
  fmt::print("\n{:<28}{:.4f} m, {:.4f} deg\n", "end-to-end error", e.end_to_end.translation,
             e.end_to_end.rotation_deg);
}

void warn_about_order(const std::string& path, const eval::TumFile& file) {
  if (file.num_out_of_order > 0)
    fmt::print(stderr, "warning: {}: {} rows out of order, sorted\n", path, file.num_out_of_order);
  if (file.num_duplicates > 0)
    fmt::print(stderr, "warning: {}: {} rows with a stamp that was there before, ignored\n", path,
               file.num_duplicates);
}

int evaluate_files(const EvaluateOptions& options) {
  const Result<eval::TumFile> truth = eval::read_tum(options.truth);
  if (!truth) return fail(truth.error());
  const Result<eval::TumFile> estimate = eval::read_tum(options.estimate);
  if (!estimate) return fail(estimate.error());
  warn_about_order(options.truth, *truth);
  warn_about_order(options.estimate, *estimate);
  const Result<eval::Evaluation> evaluation =
      eval::evaluate(truth->poses, estimate->poses, kAlignments.at(options.alignment));
  if (!evaluation) {
    return fail({evaluation.error().code, fmt::format("{} against {}: {}", options.estimate, options.truth,
                                                      evaluation.error().message)});
  }
  options.json ? print_json(*evaluation) : print_text(*evaluation);
  return 0;
}

}  // namespace

void add_evaluate(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("evaluate", "Compare an estimated trajectory with the true one");
  auto options = std::make_shared<EvaluateOptions>();
  command->add_option("TRUTH", options->truth, "the true trajectory: lines of time x y z qx qy qz qw")
      ->required();
  command->add_option("ESTIMATE", options->estimate, "the trajectory to judge, in the same format")
      ->required();
  command->add_option("--align", options->alignment, "what to align before")
      ->check(CLI::IsMember({"se3", "yaw", "none"}))
      ->capture_default_str();
  command->add_flag("--json", options->json, "print JSON instead of text");
  command->callback([options, &exit_code] { exit_code = evaluate_files(*options); });
}

}  // namespace mmlins::cli

// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "mmlins/atlas/atlas.hpp"
#include "mmlins/base/log.hpp"
#include "mmlins/base/parallel.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/config/yaml_config.hpp"
#include "mmlins/eval/trajectory_file.hpp"
#include "mmlins/io/open_dataset.hpp"
#include "mmlins/pipeline/earlier_run.hpp"
#include "mmlins/pipeline/run_files.hpp"
#include "run_report.hpp"
#include "run_view.hpp"

namespace mmlins::cli {
namespace {

struct RunOptions {
  std::string recording;
  std::string rig_file;
  std::string config_file;
  std::string out = "mmlins_out";
  std::string truth_file;
  std::string progress_file;
  std::vector<std::string> overrides;
  int num_threads = 0;
  bool view = false;
  bool view_exit = false;
  ViewerOptions viewer;
};

std::atomic<bool> stop_requested = false;
extern "C" void request_stop(int) { stop_requested = true; }

/// One line that is rewritten on a terminal, and a line now and then elsewhere.
class Progress {
 public:
  void show(const pipeline::ScanRecord& latest, double share);
  void finish() const {
    if (on_terminal_ && num_scans_ > 0) fmt::print(stderr, "\n");
  }

 private:
  bool on_terminal_ = isatty(STDERR_FILENO) != 0;
  int num_scans_ = 0;
  int next_tenth_ = 1;
  double elapsed_ms_ = 0.0;
  double last_shown_ms_ = -1e9;
  Stopwatch stopwatch_;
};

void Progress::show(const pipeline::ScanRecord& latest, double share) {
  ++num_scans_;
  elapsed_ms_ += stopwatch_.lap_ms();
  const double rate = 1e3 * num_scans_ / std::max(elapsed_ms_, 1.0);
  const std::string_view cause = odometry::to_string(latest.cause);
  const std::string text = fmt::format("{:3.0f} %  {} scans  {:.0f} scans/s  {}{}{}", 100.0 * share, num_scans_, rate,
                                       odometry::to_string(latest.state), cause.empty() ? "" : ": ", cause);
  if (on_terminal_) {
    if (elapsed_ms_ - last_shown_ms_ < 100.0) return;
    last_shown_ms_ = elapsed_ms_;
    const auto filled = static_cast<std::size_t>(20.0 * share);
    fmt::print(stderr, "\r[{}{}] {:<60}", std::string(filled, '#'), std::string(20 - std::min<std::size_t>(20, filled), '.'), text);
  } else if (10.0 * share >= next_tenth_) {
    fmt::print(stderr, "{}\n", text);
    next_tenth_ = static_cast<int>(10.0 * share) + 1;
  }
}

Status load(const RunOptions& options, sensor::Rig& rig, pipeline::SlamConfig& config) {
  if (!options.rig_file.empty()) {
    if (Status status = config::apply_yaml_file(rig.fields(), options.rig_file); !status) return status;
  }
  if (Status status = sensor::validate(rig, options.rig_file.empty() ? "rig" : options.rig_file); !status) return status;
  if (!options.config_file.empty()) {
    if (Status status = config::apply_yaml_file(config.fields(), options.config_file); !status) return status;
  }
  for (const std::string& assignment : options.overrides) {
    if (Status status = config::apply_override(config.fields(), assignment); !status) return status;
  }
  return pipeline::validate(config, options.config_file.empty() ? "config" : options.config_file);
}

void print_result(const RunOptions& options, const pipeline::RunResult& result) {
  const double seconds = pipeline::recording_seconds(result);
  std::vector<double> ms;
  for (const auto& scan : result.scans) ms.push_back(scan.total_ms());
  const auto statistics = pipeline::stage_statistics(std::move(ms));
  fmt::print("{} scans, {:.1f} s, {:.1f} m; {:.2f} ms per scan (p99 {:.1f}, max {:.1f}); {:.1f} s of work, {:.0f} MiB\n",
             result.scans.size(), seconds, pipeline::path_length(result), statistics.mean_ms, statistics.p99_ms,
             statistics.max_ms, result.wall_seconds, pipeline::peak_memory_mib());
  fmt::print("{} map points; everything lies in {}\n", result.map.num_points(), options.out);
  const auto num_carried = std::count_if(result.scans.begin(), result.scans.end(),
                                         [](const auto& scan) { return !odometry::is_placed(scan.state); });
  if (num_carried > 0) {
    log::warning("{} of {} scans were carried by the IMU alone; {}/health.csv says which and why", num_carried,
                 result.scans.size(), options.out);
  }
  const auto num_apart = std::count_if(result.maps.begin(), result.maps.end(), [&](const odometry::MapRecord& map) {
    return map.id > 0 && result.mapping.worlds[static_cast<std::size_t>(map.id)] == map.id;
  });
  if (num_apart > 0) {
    log::warning("the pose was lost on the way: of {} maps {} met no other again and lie where the IMU carried them",
                 result.maps.size(), num_apart);
  } else if (result.maps.size() > 1) {
    fmt::print("the pose was lost on the way; all {} maps found each other again\n", result.maps.size());
  }
}

/// The run itself, shown while it goes on if asked to. The atlas is whole and closed afterwards.
pipeline::RunResult run_recording(sensor::Dataset& dataset, const sensor::Rig& rig, const pipeline::SlamConfig& config,
                                  atlas::Atlas atlas, std::FILE* progress_file, RunView* view) {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  Progress progress;
  auto result = pipeline::run(dataset, rig, config, [&](const pipeline::ScanRecord& latest, double share) {
    progress.show(latest, share);
    if (progress_file) fmt::print(progress_file, "{} {}\n", eval::seconds_text(latest.time), odometry::to_string(latest.state));
    if (view) view->add(latest);
    return !stop_requested.load();
  }, &atlas);
  progress.finish();
  if (view) view->let_go();
  return result;
}

using FilePointer = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// Written line by line, so that it tells how far a run had come that was killed.
Result<FilePointer> open_progress(const std::string& path) {
  FilePointer file(path.empty() ? nullptr : std::fopen(path.c_str(), "w"), [](std::FILE* f) { return std::fclose(f); });
  if (!path.empty() && !file) return make_error(ErrorCode::kIo, "{}: cannot be written: {}", path, std::strerror(errno));
  if (file) std::setvbuf(file.get(), nullptr, _IOLBF, 0);
  return file;
}

/// The first thing that went wrong, if anything did. What there was is saved by now.
Status verdict(const pipeline::RunResult& result, const std::string& folder) {
  if (!result.mapping.error.empty()) {
    return make_error(ErrorCode::kIo, "{}; all else was saved in {}", result.mapping.error, folder);
  }
  if (!result.read_error.empty()) {
    return make_error(ErrorCode::kIo, "{}; what came before it was saved", result.read_error);
  }
  if (result.interrupted) {
    return make_error(ErrorCode::kInterrupted, "interrupted; the {} scans so far were saved in {}", result.scans.size(), folder);
  }
  return {};
}

/// Leaves nothing of a run that came to nothing, and an earlier one as it was.
void remove_traces(const std::string& folder, bool is_new_folder, const pipeline::EarlierRun& earlier) {
  std::error_code not_empty;
  std::filesystem::remove_all(folder + "/atlas", not_empty);
  if (const Status status = earlier.put_back(); !status) log::warning("{}", status.error().message);
  if (is_new_folder) std::filesystem::remove(folder, not_empty);
}

int run(const RunOptions& options) {
  sensor::Rig rig;
  pipeline::SlamConfig config;
  if (Status status = load(options, rig, config); !status) return fail(status.error());
  if (Status status = options.view ? check_viewer() : Status{}; !status) return fail(status.error());
  parallel::set_num_threads(options.num_threads);
  const auto truth = read_truth(options.truth_file);
  if (!truth) return fail(truth.error());
  auto opened = io::open_dataset(options.recording, rig);
  if (!opened) return fail(opened.error());
  const auto progress_file = open_progress(options.progress_file);
  if (!progress_file) return fail(progress_file.error());
  const bool is_new_folder = !std::filesystem::exists(options.out);
  if (Status status = pipeline::prepare_folder(options.out); !status) return fail(status.error());
  const auto earlier = pipeline::EarlierRun::put_aside(options.out);
  if (!earlier) return fail(earlier.error());
  auto atlas = atlas::Atlas::create(options.out + "/atlas");
  if (!atlas) return fail(atlas.error());
  if (earlier->exists()) log::info("{}: the run that is there stays in earlier_run until this one has come to its end", options.out);
  std::unique_ptr<RunView> view;
  if (options.view) {
    auto started = RunView::start(options.out, options.viewer);
    if (!started) {
      remove_traces(options.out, is_new_folder, *earlier);
      return fail(started.error());
    }
    view = std::move(*started);
  }
  const auto result = run_recording(*opened->dataset, rig, config, std::move(*atlas), progress_file->get(), view.get());
  if (result.scans.empty()) {
    remove_traces(options.out, is_new_folder, *earlier);
    return fail(make_error(ErrorCode::kInvalid, "{}: no scan could be used{}{}; look at it with: mmlins info {}",
                           options.recording, result.read_error.empty() ? "" : ": ", result.read_error, options.recording));
  }
  rig.lidar_topic = opened->info.lidar->topic;
  rig.imu_topic = opened->info.imu->topic;
  const pipeline::RunSource source{options.recording, rig.lidar_topic, rig.imu_topic, parallel::num_threads()};
  if (Status status = pipeline::write_run(options.out, result, source, rig, config); !status) return fail(status.error());
  print_result(options, result);
  const report::ReportInput shown{result, source, rig, config, &opened->info};
  if (Status status = write_report(options.out, shown, *truth, options.truth_file); !status) return fail(status.error());
  if (Status status = earlier->remove(); !status) log::warning("{}", status.error().message);
  if (view && !options.view_exit && !stop_requested) view->stay(options.out, stop_requested);
  const Status status = verdict(result, options.out);
  return status ? 0 : fail(status.error());
}

}  // namespace

void add_run(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = program.add_subcommand("run", "A recording in, a trajectory and a map out");
  command->add_option("RECORDING", options->recording, "ROS 1 bag with a LiDAR and an IMU")->required();
  command->add_option("--rig", options->rig_file, "the sensors: topics, extrinsics, IMU noise (YAML)");
  command->add_option("--config", options->config_file, "parameters of the method (YAML); hardly ever needed");
  command->add_option("--set", options->overrides, "one parameter, as group.key=value; may be repeated");
  command->add_option("--out", options->out, "output folder")->capture_default_str();
  command->add_option("--truth", options->truth_file, "the true trajectory (TUM), to show errors in the report");
  command->add_option("--progress", options->progress_file, "a file that gets a line for each scan as it is done: its time and state");
  command->add_option("--threads", options->num_threads, "threads to use; 0: all cores. The result is the same")
      ->check(CLI::Range(0, 1024));
  CLI::Option* view = command->add_flag("--view", options->view, "show the run in the browser while it goes on, and its result until Ctrl-C");
  command->add_flag("--view-exit", options->view_exit, "with --view: end with the run")->needs(view);
  add_viewer_options(*command, options->viewer, view);
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace mmlins::cli

// SPDX-License-Identifier: MIT
// mmlins simulate: a made-up recording with its truth, from a named scenario or a YAML file.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/base/text_file.hpp"
#include "mmlins/config/yaml_config.hpp"
#include "mmlins/eval/trajectory_file.hpp"
#include "mmlins/io/rosbag1_writer.hpp"
#include "mmlins/sim/map_picture.hpp"
#include "mmlins/sim/open_simulation.hpp"
#include "mmlins/sim/scenario.hpp"

namespace mmlins::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLidarFrame = "lidar";
constexpr const char* kImuFrame = "imu";
constexpr double kTruthRate = 100.0;  // [Hz]

struct SimulateOptions {
  std::string scenario;
  std::string out;
  std::vector<std::string> overrides;
  bool list = false;
};

std::atomic<bool> interrupted = false;
void on_interrupt(int) { interrupted = true; }

/// One line that is rewritten on a terminal, and a line now and then elsewhere.
class SimulateProgress {
 public:
  void show(double share) {
    elapsed_ms_ += stopwatch_.lap_ms();
    if (on_terminal_) {
      if (elapsed_ms_ - shown_ms_ < 100.0) return;
      shown_ms_ = elapsed_ms_;
      const auto filled = static_cast<std::size_t>(20.0 * share);
      fmt::print(stderr, "\r[{:.<20}] {:3.0f} %", std::string(filled, '#'), 100.0 * share);
    } else if (share >= next_share_) {
      fmt::print(stderr, "simulated {:.0f} %\n", 100.0 * share);
      next_share_ += 0.25;
    }
  }
  void finish() const {
    if (on_terminal_) fmt::print(stderr, "\r{:<32}\r", "");
  }
  double elapsed_seconds() { return 1e-3 * (elapsed_ms_ += stopwatch_.lap_ms()); }

 private:
  bool on_terminal_ = isatty(STDERR_FILENO) != 0;
  double next_share_ = 0.25;
  double elapsed_ms_ = 0.0;
  double shown_ms_ = -1e9;
  Stopwatch stopwatch_;
};

// The scenarios, one a line, and what they can be made of.
int list_scenarios() {
  std::size_t width = 26;
  for (const sim::ScenarioText& scenario : sim::scenario_texts())
    width = std::max(width, scenario.name.size() + 2);
  for (const sim::ScenarioText& scenario : sim::scenario_texts())
    fmt::print("{:<{}}{}\n", scenario.name, width, sim::summary_of(scenario));
  fmt::print("\nscenes (world.scene): {}\n", fmt::join(sim::scene_names(), ", "));
  fmt::print("sensors (sensor.model):\n");
  for (const sim::NamedText& sensor : sim::sensor_texts())
    fmt::print("  {:<10}{}\n", sensor.name, sim::summary_of(sensor));
  fmt::print("inertial sensors (imu.model): {}\n", fmt::join(sim::imu_names(), ", "));
  fmt::print("carriers (trajectory.carrier): {}\n", fmt::join(sim::carrier_names(), ", "));
  fmt::print("events (events: [{{kind, start, duration, severity}}]):\n");
  for (const degrade::KindInfo& kind : degrade::event_kinds()) {
    const std::string severity =
        kind.range.min == kind.range.max
            ? "no severity"
            : fmt::format("severity: {}, {} to {}{}, usually {}", kind.severity_meaning, kind.range.min,
                          kind.range.max, kind.unit.empty() ? "" : " " + kind.unit, kind.usual);
    fmt::print("  {:<13}{}\n", kind.word, severity);
  }
  return 0;
}

struct Written {
  int num_scans = 0;
  std::size_t num_points = 0;
  int num_imu = 0;
};

Status write_item(io::RosbagWriter& bag, const sensor::Rig& rig, const sensor::Item& item, Time record_time,
                  Written& written) {
  if (const auto* scan = std::get_if<sensor::LidarScan>(&item)) {
    ++written.num_scans;
    written.num_points += scan->size();
    return bag.write_scan(rig.lidar_topic, kLidarFrame, *scan, record_time);
  }
  ++written.num_imu;
  return bag.write_imu(rig.imu_topic, kImuFrame, std::get<sensor::ImuSample>(item), record_time);
}

Result<Written> write_bag(const std::string& path, sim::Simulation& simulation, SimulateProgress& progress) {
  auto bag = io::RosbagWriter::create(path);
  if (!bag) return bag.error();
  const sensor::Rig rig = simulation.rig();
  Written written;
  while (true) {
    const auto item = simulation.next();
    if (!item) return item.error();
    if (std::holds_alternative<sensor::EndOfData>(*item)) break;
    if (const Status status = write_item(*bag, rig, *item, simulation.record_time(), written); !status)
      return status.error();
    if (interrupted) return make_error(ErrorCode::kInterrupted, "interrupted; {} was not written", path);
    progress.show(simulation.progress());
  }
  if (const Status status = bag->close(); !status) return status.error();
  return written;
}

Status write_descriptions(const fs::path& out, const sim::Simulation& simulation,
                          sim::SimulationConfig& config) {
  sensor::Rig rig = simulation.rig();
  if (const Status status = write_text_file((out / "rig.yaml").string(), config::to_yaml(rig.fields(), true));
      !status) {
    return status;
  }
  if (const Status status =
          write_text_file((out / "scenario.yaml").string(), config::to_yaml(config.fields(), true));
      !status) {
    return status;
  }
  if (const Status status = write_text_file((out / "events.csv").string(),
                                            degrade::events_csv(config.events, simulation.start_time()));
      !status) {
    return status;
  }
  return eval::write_tum((out / "truth.tum").string(), simulation.truth(kTruthRate));
}

Result<Written> simulate_into(const fs::path& out, sim::Simulation& simulation, SimulateProgress& progress) {
  sim::SimulationConfig config = simulation.config();
  auto written = write_bag((out / "recording.bag").string(), simulation, progress);
  progress.finish();
  if (!written) return written;
  if (const Status status = write_descriptions(out, simulation, config); !status) return status.error();
  if (const Status status = write_text_file((out / "map.svg").string(), sim::map_svg(simulation)); !status)
    return status.error();
  return written;
}

int simulate(const SimulateOptions& options) {
  auto config = sim::load_scenario(options.scenario, options.overrides);
  if (!config) return fail(config.error());
  const auto simulation = sim::open_simulation(*config, options.scenario);
  if (!simulation) return fail(simulation.error());

  const fs::path out(options.out);
  std::error_code failure;
  const bool is_new = fs::create_directories(out, failure);
  if (failure || access(out.c_str(), W_OK) != 0) {
    return fail(make_error(ErrorCode::kIo, "{}: cannot write there{}; choose another --out", options.out,
                           failure ? " (" + failure.message() + ")" : ""));
  }
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  SimulateProgress progress;
  const auto written = simulate_into(out, **simulation, progress);
  if (!written) {
    if (is_new) fs::remove(out, failure);  // only if nothing is in it
    return fail(written.error());
  }
  fmt::print("{}: {} scans with {} points, {} IMU samples, {:.0f} s recorded in {:.1f} s\n",
             (out / "recording.bag").string(), written->num_scans, written->num_points, written->num_imu,
             config->duration, progress.elapsed_seconds());
  fmt::print(
      "{}: the true poses; rig.yaml, scenario.yaml, events.csv and the picture map.svg lie beside them\n",
      (out / "truth.tum").string());
  return 0;
}

}  // namespace

void add_simulate(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command = program.add_subcommand("simulate", "Make up a recording, with its truth");
  command->add_option("SCENARIO", options->scenario, "name of a built-in scenario, or a YAML file");
  command->add_option("--out", options->out,
                      "folder for recording.bag, truth.tum, events.csv, map.svg, rig.yaml and scenario.yaml");
  command
      ->add_option("--set", options->overrides,
                   "change a field of the scenario, as group.key=value; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--list", options->list,
                    "list the built-in scenarios, and what scenarios can be made of");
  command->callback([options, &exit_code] {
    const bool is_whole = options->list || (!options->scenario.empty() && !options->out.empty());
    if (!is_whole) throw CLI::RequiredError("SCENARIO with --out FOLDER, or --list,");
    exit_code = options->list ? list_scenarios() : simulate(*options);
  });
}

}  // namespace mmlins::cli

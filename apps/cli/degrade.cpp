// SPDX-License-Identifier: MIT
// mmlins degrade: a recording whose LiDAR fails for a while; everything else is copied byte for byte.

#include <fmt/format.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "mmlins/base/log.hpp"
#include "mmlins/base/text_file.hpp"
#include "mmlins/config/yaml_config.hpp"
#include "mmlins/degrade/scan_degrader.hpp"
#include "mmlins/io/lidar_message_edit.hpp"
#include "mmlins/io/probe.hpp"
#include "mmlins/io/rosbag1/rosbag1_raw_writer.hpp"
#include "mmlins/io/topic_choice.hpp"

namespace mmlins::cli {
namespace {

namespace fs = std::filesystem;

// Stamps that differ by more from the times of recording come from another clock. [s]
constexpr double kSameClock = 1.0;

struct DegradeCommandOptions {
  std::string in;
  std::string out;
  std::vector<std::string> events;
  std::string lidar_topic;
  std::string rig;
  int seed = 1;
};

std::atomic<bool> degrade_interrupted = false;
void on_degrade_interrupt(int) { degrade_interrupted = true; }

struct Counts {
  std::size_t scans = 0;
  std::size_t changed = 0;
  std::size_t lost = 0;
  std::size_t points = 0;
  std::size_t points_left = 0;
  std::size_t unreadable = 0;
};

/// The recording and what is to be done to it.
struct Job {
  io::Rosbag1Reader reader;
  std::size_t lidar_topic = 0;
  std::unique_ptr<io::LidarMessageEditor> editor;
  std::unique_ptr<degrade::ScanDegrader> degrader;
  std::vector<degrade::EventSpec> events;
  Time start;  ///< of the recording, in the clock of the LiDAR
};

Result<std::vector<degrade::EventSpec>> read_events(const std::vector<std::string>& texts, Duration length,
                                                    const std::string& source) {
  std::vector<degrade::EventSpec> events;
  for (const std::string& text : texts) {
    const auto event = degrade::parse_event(text);
    if (!event) return event.error();
    if (const Status status = degrade::validate(*event, length, source); !status) return status.error();
    events.push_back(*event);
  }
  return events;
}

Result<sensor::Rig> read_rig(const DegradeCommandOptions& options) {
  sensor::Rig rig;
  if (!options.rig.empty()) {
    if (const Status status = config::apply_yaml_file(rig.fields(), options.rig); !status)
      return status.error();
  }
  if (!options.lidar_topic.empty()) rig.lidar_topic = options.lidar_topic;
  return rig;
}

/// When the recording begins by the clock of the LiDAR's stamps.
Result<Time> start_by_stamps(io::Rosbag1Reader& reader, std::size_t topic,
                             const io::LidarMessageEditor& editor) {
  if (const Status status = reader.select({topic}); !status) return status.error();
  while (true) {
    const auto message = reader.next();
    if (!message) return message.error();
    if (!message->has_value()) return reader.start_time();
    const auto points = editor.read(io::Bytes((*message)->data, (*message)->size));
    if (!points) continue;
    const Duration ahead = points->stamp - (*message)->record_time;
    if (std::abs(to_seconds(ahead)) <= kSameClock) return reader.start_time();
    log::warning(
        "{}: the stamps of {} are {:.3f} s away from the times of recording; events go by the stamps",
        reader.path(), reader.topics()[topic].name, to_seconds(ahead));
    return reader.start_time() + ahead;
  }
}

Result<Job> prepare(const DegradeCommandOptions& options) {
  auto reader = io::Rosbag1Reader::open(options.in);
  if (!reader) return reader.error();
  const auto rig = read_rig(options);
  if (!rig) return rig.error();
  auto events = read_events(options.events, reader->end_time() - reader->start_time(), options.in);
  if (!events) return events.error();
  const auto topic = io::choose_lidar_topic(*reader, *rig);
  if (!topic) return make_error(topic.error().code, "{} (or give --lidar-topic)", topic.error().message);
  auto info = io::probe_lidar(*reader, *topic, *rig);
  if (!info) return info.error();
  auto editor = std::make_unique<io::LidarMessageEditor>(std::move(*info));
  const auto start = start_by_stamps(*reader, *topic, *editor);
  if (!start) return start.error();
  const degrade::DegradeOptions how{static_cast<std::uint64_t>(options.seed),
                                    options.rig.empty() ? 0.0 : rig->min_range};
  auto degrader = std::make_unique<degrade::ScanDegrader>(*events, *start, how);
  return Job{std::move(*reader), *topic, std::move(editor), std::move(degrader), std::move(*events), *start};
}

Status copy(const io::RawMessage& message, io::Bytes bytes, io::Rosbag1RawWriter& bag) {
  return bag.write_to(message.connection, message.record_time, bytes.data(), bytes.size());
}

Status write_degraded(const Job& job, const io::RawMessage& message, io::Rosbag1RawWriter& bag,
                      Counts& counts) {
  const io::Bytes bytes(message.data, message.size);
  const auto points = job.editor->read(bytes);
  if (!points) {
    if (counts.unreadable++ == 0) {
      log::warning("{}: a message was left as it is: {}", job.reader.topics()[message.topic].name,
                   points.error().message);
    }
    return copy(message, bytes, bag);
  }
  const degrade::DegradedSweep sweep = job.degrader->apply({points->stamp, &points->points, &points->times});
  ++counts.scans;
  counts.points += points->points.size();
  counts.points_left += sweep.lost ? 0 : sweep.kept.size();
  counts.lost += sweep.lost ? 1 : 0;
  if (sweep.lost) return {};
  if (!sweep.changed) return copy(message, bytes, bag);
  ++counts.changed;
  const auto edited = job.editor->rewrite(bytes, sweep.kept, sweep.points);
  if (!edited) return edited.error();
  return copy(message, io::Bytes(*edited), bag);
}

Result<Counts> write_bag(Job& job, const std::string& path) {
  auto bag = io::Rosbag1RawWriter::create(path);
  if (!bag) return bag.error();
  std::vector<std::size_t> all(job.reader.topics().size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  for (const io::BagConnection& connection : job.reader.connections()) (void)bag->add_connection(connection);
  if (const Status status = job.reader.select(all); !status) return status.error();
  Counts counts;
  while (true) {
    const auto message = job.reader.next();
    if (!message) return message.error();
    if (!message->has_value()) break;
    const io::RawMessage& raw = **message;
    const Status status = raw.topic == job.lidar_topic ? write_degraded(job, raw, *bag, counts)
                                                       : copy(raw, io::Bytes(raw.data, raw.size), *bag);
    if (!status) return status.error();
    if (degrade_interrupted)
      return make_error(ErrorCode::kInterrupted, "interrupted; {} was not written", path);
  }
  if (const Status status = bag->close(); !status) return status.error();
  return counts;
}

/// Beside the bag and named after it, so that it hides neither the table of the recording nor that of another copy.
std::string table_of(const fs::path& bag) {
  const fs::path name = bag.extension() == ".bag" ? bag.stem() : bag.filename();
  return (bag.parent_path() / name).string() + ".events.csv";
}

Result<Counts> write_into_folder(Job& job, const fs::path& bag) {
  const fs::path folder = bag.parent_path();
  std::error_code failure;
  const bool is_new = !folder.empty() && fs::create_directories(folder, failure);
  if (failure) {
    return make_error(ErrorCode::kIo, "{}: cannot create the folder {} ({}); choose another place for the bag", bag.string(),
                      folder.string(), failure.message());
  }
  auto counts = write_bag(job, bag.string());
  if (!counts && is_new) fs::remove(folder, failure);  // only if nothing is in it
  return counts;
}

int degrade_command(const DegradeCommandOptions& options) {
  std::error_code ignored;
  if (fs::equivalent(options.in, options.out, ignored)) {
    return fail(
        make_error(ErrorCode::kInvalid, "{}: is the recording itself; give another name", options.out));
  }
  auto job = prepare(options);
  if (!job) return fail(job.error());
  std::signal(SIGINT, on_degrade_interrupt);
  std::signal(SIGTERM, on_degrade_interrupt);
  const auto counts = write_into_folder(*job, options.out);
  if (!counts) return fail(counts.error());
  const std::string table = table_of(options.out);
  if (const Status status = write_text_file(table, degrade::events_csv(job->events, job->start)); !status) {
    return fail(status.error());
  }
  fmt::print("{}: {} of {} scans changed, {} lost, {} of {} points left\n", options.out, counts->changed,
             counts->scans, counts->lost, counts->points_left, counts->points);
  fmt::print("{}: when each event begins and ends\n", table);
  return 0;
}

}  // namespace

void add_degrade(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<DegradeCommandOptions>();
  CLI::App* command = program.add_subcommand("degrade", "Copy a recording whose LiDAR fails for a while");
  command->add_option("IN", options->in, "ROS 1 bag")->required();
  command->add_option("OUT", options->out, "the bag to write, for instance x.bag; x.events.csv goes beside it")->required();
  command
      ->add_option("--event", options->events,
                   "kind:start:duration[:severity], in seconds from the start; may be repeated. Kinds: " +
                       degrade::list_of_kinds())
      ->required()
      ->allow_extra_args(false);
  command->add_option("--lidar-topic", options->lidar_topic, "if the bag has more than one LiDAR");
  command->add_option("--rig", options->rig, "YAML file that describes the sensors");
  command->add_option("--seed", options->seed, "of what is random")->check(CLI::Range(0, 1'000'000'000));
  command->callback([options, &exit_code] { exit_code = degrade_command(*options); });
}

}  // namespace mmlins::cli

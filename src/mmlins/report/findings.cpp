// SPDX-License-Identifier: MIT
#include "mmlins/report/findings.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace mmlins::report {
namespace {

constexpr double kUsable = 1.0;  // a map that is placed worse must not be relied on [m]

using odometry::TrackingState;
using pipeline::RunResult;

/// The same word with an s unless it is one.
std::string counted(std::ptrdiff_t count, const std::string& one) {
  return count == 1 ? "1 " + one : fmt::format("{} {}s", count, one);
}

std::string times_text(std::ptrdiff_t count) {
  return count == 1 ? "once" : count == 2 ? "twice" : fmt::format("{} times", count);
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += parts[i];
    if (i + 2 < parts.size()) text += ", ";
    if (i + 2 == parts.size()) text += " and ";
  }
  return text;
}

std::set<int> worlds_of(const RunResult& result) { return {result.mapping.worlds.begin(), result.mapping.worlds.end()}; }

std::ptrdiff_t num_carried(const RunResult& result) {
  return std::count_if(result.scans.begin(), result.scans.end(), [](const auto& scan) { return !is_placed(scan.state); });
}

double scan_period(const RunResult& result) {
  return result.scans.size() < 2 ? 0.0 : pipeline::recording_seconds(result) / static_cast<double>(result.scans.size() - 1);
}

void find_reading_faults(const ReportInput& input, std::vector<Finding>& list) {
  const RunResult& result = input.result;
  if (!result.read_error.empty()) {
    list.push_back({Level::kBad, "Reading the recording ended early: " + result.read_error + ". Everything before is here."});
  }
  if (result.interrupted) list.emplace_back(Level::kWarning, "The run was interrupted; this is what there was until then.");
  if (!result.mapping.error.empty()) list.push_back({Level::kBad, "The back end failed: " + result.mapping.error + "."});
  if (result.num_scans_without_imu > 0) {
    list.push_back({Level::kNote, fmt::format("{} before the IMU began left out.",
                                              counted(result.num_scans_without_imu, "scan") +
                                                  (result.num_scans_without_imu == 1 ? " was" : " were"))});
  }
  if (result.num_scans_not_later > 0) {
    list.push_back({Level::kWarning, counted(result.num_scans_not_later, "scan") +
                                         " left out: no later than the scan before. Look at the stamps of the LiDAR."});
  }
  if (result.num_scans_ahead > 0) {
    list.push_back({Level::kWarning, counted(result.num_scans_ahead, "scan") +
                                         " left out: stamped ahead of the IMU and of what came after. Look at the stamps of the LiDAR."});
  }
  if (result.num_late_imu_samples > 0) {
    list.push_back({Level::kNote, counted(result.num_late_imu_samples, "IMU sample") +
                                      " left out: duplicate or too late."});
  }
  if (result.num_clock_jumps > 0) {
    list.push_back({Level::kWarning, "The clock of the recording was set back " + times_text(result.num_clock_jumps) +
                                         "; later stamps were shifted so that time goes on."});
  }
}

/// Which causes there were, with their share of the time.
std::string causes_of(const RunResult& result) {
  std::map<odometry::Cause, int> counts;
  for (const auto& scan : result.scans) {
    if (!is_placed(scan.state) && scan.cause != odometry::Cause::kNone) ++counts[scan.cause];
  }
  std::vector<std::string> parts;
  for (const auto& [cause, count] : counts) {
    parts.push_back(fmt::format("{} ({:.1f} s)", to_string(cause), count * scan_period(result)));
  }
  return joined(parts);
}

void find_carried(const RunResult& result, std::vector<Finding>& list) {
  if (const auto carried = num_carried(result); carried > 0) {
    const std::string causes = causes_of(result);
    list.push_back({Level::kWarning,
                    fmt::format("{} of {} scans, {:.1f} s, were carried by the IMU alone{}{}.", carried, result.scans.size(),
                                static_cast<double>(carried) * scan_period(result), causes.empty() ? "" : ": ", causes)});
  }
  if (!result.scans.empty() && !is_placed(result.scans.back().state)) {
    list.push_back({Level::kBad, fmt::format("The recording ends while the pose is carried by the IMU alone ({}): the last poses "
                                             "drift, and nothing later puts them right.",
                                             to_string(result.scans.back().state))});
  }
  const auto weak = std::count_if(result.scans.begin(), result.scans.end(),
                                  [](const auto& scan) { return scan.state == TrackingState::kDegraded; });
  if (weak > 0) {
    list.push_back({Level::kNote, fmt::format("{} ({:.1f} %) left directions to the IMU, because the surroundings do not "
                                              "determine them; see Observability.",
                                              counted(weak, "scan"), 100.0 * static_cast<double>(weak) /
                                                                         static_cast<double>(result.scans.size()))});
  }
}

/// How well a map that was joined to no other is placed.
Finding placement_of(const odometry::MapRecord& map) {
  if (!map.gap) return {Level::kBad, "nothing tells where it lies"};
  if (!map.gap->is_known) return {Level::kBad, "the IMU was silent in the gap before it or went wrong, so nobody knows where it lies"};
  const double std = map.gap->covariance.diagonal().tail<3>().cwiseMax(0.0).cwiseSqrt().maxCoeff();
  return {std > kUsable ? Level::kBad : Level::kWarning,
          fmt::format("what the IMU felt tells where it lies, over the {:.1f} s before it to about {:.2g} m",
                      to_seconds(map.gap->first - map.gap->last), std)};
}

void find_maps_apart(const RunResult& result, std::vector<Finding>& list) {
  const std::set<int> worlds = worlds_of(result);
  for (const int world : worlds) {
    if (world == *worlds.begin()) continue;
    std::vector<std::string> names;
    for (std::size_t id = 0; id < result.mapping.worlds.size(); ++id) {
      if (result.mapping.worlds[id] == world) names.push_back(std::to_string(id));
    }
    const bool one = names.size() == 1;
    const auto first = static_cast<std::size_t>(world);
    const Finding placement = first < result.maps.size() ? placement_of(result.maps[first]) : Finding{Level::kBad, "it is lost"};
    list.push_back({placement.level, fmt::format("Map{} {} {} never recognised in map {}: {}.", one ? "" : "s", joined(names),
                                                 one ? "was" : "were", *worlds.begin(), placement.text)});
  }
}

void find_closure_faults(const RunResult& result, std::vector<Finding>& list) {
  const auto rejected = std::count_if(result.mapping.closures.begin(), result.mapping.closures.end(), [](const auto& closure) {
    return closure.state == mapping::ClosureState::kRejected;
  });
  if (rejected > 0) {
    list.push_back({Level::kNote, counted(rejected, "closure") + " believed at first and rejected later, when others spoke against " +
                                      (rejected == 1 ? "it." : "them.")});
  }
}

void find_slowness(const RunResult& result, std::vector<Finding>& list) {
  std::vector<double> ms;
  for (const auto& scan : result.scans) ms.push_back(scan.total_ms());
  const auto statistics = pipeline::stage_statistics(std::move(ms));
  const double period_ms = 1e3 * scan_period(result);
  if (period_ms <= 0.0) return;
  if (statistics.mean_ms > period_ms) {
    list.push_back({Level::kWarning, fmt::format("Slower than the sensor: {:.1f} ms of work per scan on average, one scan every "
                                                 "{:.1f} ms.", statistics.mean_ms, period_ms)});
  } else if (statistics.p99_ms > period_ms) {
    list.push_back({Level::kNote, fmt::format("One scan in a hundred takes longer ({:.1f} ms) than the time between scans "
                                              "({:.1f} ms).", statistics.p99_ms, period_ms)});
  }
}

void find_topic_gaps(const ReportInput& input, std::vector<Finding>& list) {
  if (input.recording == nullptr) return;
  for (const io::TopicInfo& topic : input.recording->topics) {
    if ((topic.name != input.source.imu_topic && topic.name != input.source.lidar_topic) || topic.timing.num_gaps == 0) continue;
    list.push_back({Level::kNote, fmt::format("{} pauses {} for more than three periods, at most for {:.2f} s.", topic.name,
                                              times_text(topic.timing.num_gaps), to_seconds(topic.timing.longest_gap))});
  }
}

Finding headline_of(const RunResult& result, Level worst) {
  const auto num_maps = static_cast<std::ptrdiff_t>(result.maps.size());
  const auto num_worlds = static_cast<std::ptrdiff_t>(worlds_of(result).size());
  const auto carried = num_carried(result);
  if (!result.read_error.empty()) return {Level::kBad, "The recording could not be read to its end."};
  if (!is_placed(result.scans.back().state)) return {Level::kBad, "The pose was lost and not found again before the end."};
  if (num_worlds > 1) {
    return {worst, fmt::format("The pose was lost {}, and not everything was joined again: {} maps in {} pieces.",
                               times_text(num_maps - 1), num_maps, num_worlds)};
  }
  if (!result.mapping.error.empty()) return {Level::kBad, "The odometry is complete, the back end is not."};
  if (num_maps > 1) {
    return {Level::kWarning, fmt::format("The pose was lost {}, and {} maps were joined again into one.",
                                         times_text(num_maps - 1), num_maps == 2 ? "both" : fmt::format("all {}", num_maps))};
  }
  if (carried > 0) {
    return {Level::kWarning, fmt::format("One map; the IMU bridged {:.1f} s without a usable scan.",
                                         static_cast<double>(carried) * scan_period(result))};
  }
  if (result.interrupted) return {Level::kWarning, "Every scan until the interruption was placed in one map."};
  if (worst == Level::kWarning) return {Level::kWarning, "Every scan was placed in one map, but something needs a look."};
  return {Level::kGood, "All is well: every scan was placed in one map."};
}

}  // namespace

std::string_view to_string(Level level) {
  switch (level) {
    case Level::kGood: return "good";
    case Level::kNote: return "note";
    case Level::kWarning: return "warning";
    case Level::kBad: return "bad";
  }
  return "";
}

Findings findings_of(const ReportInput& input) {
  Findings findings;
  find_reading_faults(input, findings.list);
  find_maps_apart(input.result, findings.list);
  find_carried(input.result, findings.list);
  find_closure_faults(input.result, findings.list);
  find_slowness(input.result, findings.list);
  find_topic_gaps(input, findings.list);
  std::stable_sort(findings.list.begin(), findings.list.end(), [](const Finding& a, const Finding& b) { return a.level > b.level; });
  findings.headline = headline_of(input.result, findings.list.empty() ? Level::kGood : findings.list.front().level);
  return findings;
}

}  // namespace mmlins::report

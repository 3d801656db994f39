// SPDX-License-Identifier: MIT
#include "mmlins/view/scene.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "mmlins/base/text_file.hpp"
#include "mmlins/eval/trajectory_file.hpp"

namespace mmlins::view {
namespace {

namespace fs = std::filesystem;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

/// Where the columns of health.csv are that are shown.
struct Columns {
  std::size_t time = 0, state = 0, cause = 0, map = 0, total_ms = 0, count = 0;
};

std::optional<Columns> find_columns(std::string_view header) {
  const auto names = split(header, ',');
  Columns columns{.count = names.size()};
  const std::pair<const char*, std::size_t*> wanted[] = {{"time", &columns.time},
                                                         {"state", &columns.state},
                                                         {"cause", &columns.cause},
                                                         {"map", &columns.map},
                                                         {"total_ms", &columns.total_ms}};
  for (const auto& [name, column] : wanted) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    *column = static_cast<std::size_t>(found - names.begin());
  }
  return columns;
}

std::optional<SceneScan> read_row(std::string_view line, const Columns& columns, ScanNames& names) {
  const auto values = split(line, ',');
  if (values.size() != columns.count) return std::nullopt;
  const auto nanoseconds = eval::parse_seconds_as_ns(values[columns.time]);
  SceneScan scan;
  const auto number = [](std::string_view text, auto& value) {
    return std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
  };
  if (!nanoseconds || !number(values[columns.map], scan.map_id) ||
      !number(values[columns.total_ms], scan.total_ms)) {
    return std::nullopt;
  }
  scan.time = time_from_ns(*nanoseconds);
  scan.state = names.state(values[columns.state]);
  scan.cause = names.cause(values[columns.cause]);
  return scan;
}

Result<Scans> read_health(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return text.error();
  const auto lines = split(*text, '\n');
  const auto columns = find_columns(lines.front());
  if (!columns) return make_error(ErrorCode::kInvalid, "{}: its header is not that of a health.csv", path);
  Scans scans;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    const auto scan = read_row(lines[i], *columns, scans.names);
    if (!scan) return make_error(ErrorCode::kInvalid, "{}: line {} cannot be read", path, i + 1);
    scans.scans.push_back(*scan);
  }
  return scans;
}

/// One line that says why this is not the folder of a finished run.
Status check_files(const std::string& folder) {
  std::error_code failure;
  if (!fs::exists(folder, failure))
    return make_error(ErrorCode::kNotFound, "{}: there is no such folder", folder);
  if (!fs::is_directory(folder, failure)) {
    return make_error(ErrorCode::kInvalid, "{}: is not a folder; give the one that mmlins run wrote (--out)",
                      folder);
  }
  const auto has = [&](const char* name) { return fs::exists(fs::path(folder) / name, failure); };
  const bool has_atlas = has("atlas/index.sqlite");
  if (!has_atlas && !has("summary.json")) {
    return make_error(ErrorCode::kInvalid,
                      "{}: is not the result of a run; make one with: mmlins run RECORDING --out DIR",
                      folder);
  }
  if (!has_atlas) {
    return make_error(ErrorCode::kInvalid,
                      "{}: there are no maps in it (atlas/index.sqlite is missing); run again", folder);
  }
  for (const char* name : {"trajectory.tum", "health.csv", "summary.json"}) {
    if (has(name)) continue;
    return make_error(
        ErrorCode::kInvalid,
        "{}: the run has not come to its end ({} is missing); mmlins maps {} list tells what there is",
        folder, name, folder);
  }
  return {};
}

}  // namespace

int ScanNames::index(std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  names.emplace_back(name);
  return static_cast<int>(names.size()) - 1;
}

Result<MapsAndEdges> read_maps_and_edges(const atlas::Atlas& atlas) {
  auto maps = atlas.maps();
  if (!maps) return maps.error();
  auto keyframes = atlas.keyframes();
  if (!keyframes) return keyframes.error();
  auto edges = atlas.edges();
  if (!edges) return edges.error();
  auto merges = atlas.merges();
  if (!merges) return merges.error();
  std::erase_if(*edges,
                [](const atlas::EdgeRow& row) { return row.edge.kind == graph::EdgeKind::kOdometry; });
  return MapsAndEdges{std::move(*maps), std::move(*keyframes), std::move(*edges), std::move(*merges)};
}

Result<Scans> read_scans(const std::string& folder) {
  auto scans = read_health(folder + "/health.csv");
  if (!scans) return scans;
  const auto poses = eval::read_tum(folder + "/trajectory.tum");
  if (!poses) return poses.error();
  bool agree = poses->poses.size() == scans->scans.size();
  for (std::size_t i = 0; agree && i < scans->scans.size(); ++i) {
    agree = poses->poses[i].time == scans->scans[i].time;
    scans->scans[i].T_world_imu = poses->poses[i].pose;
  }
  if (agree) return scans;
  return make_error(ErrorCode::kInvalid,
                    "{0}: trajectory.tum and health.csv are of different runs; run again", folder);
}

Result<RunFolder> open_run(const std::string& folder) {
  if (const Status status = check_files(folder); !status) return status.error();
  auto atlas = atlas::Atlas::open(folder + "/atlas", atlas::Access::kRead);
  if (!atlas) return atlas.error();
  auto maps = read_maps_and_edges(*atlas);
  if (!maps) return maps.error();
  for (const atlas::MapRow& map : maps->maps) {
    if (map.state != atlas::MapState::kActive) continue;
    return make_error(ErrorCode::kInvalid, "{}: the run has not come to its end (map {} is still active)",
                      folder, map.id);
  }
  auto scans = read_scans(folder);
  if (!scans) return scans.error();
  auto summary = read_text_file(folder + "/summary.json");
  if (!summary) return summary.error();
  const std::string name = fs::weakly_canonical(folder).filename().string();
  return RunFolder{name, std::make_shared<const atlas::Atlas>(std::move(*atlas)), std::move(*maps),
                   std::move(*scans), std::move(*summary)};
}

}  // namespace mmlins::view

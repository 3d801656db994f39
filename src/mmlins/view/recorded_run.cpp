// SPDX-License-Identifier: MIT
#include "mmlins/view/recorded_run.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mmlins/eval/trajectory_file.hpp"

namespace mmlins::view {
namespace {

/// What the page tells of summary.json; the configuration is too long to be sent for nothing.
std::string shorten(const std::string& summary) {
  nlohmann::json parsed = nlohmann::json::parse(summary, nullptr, false);
  if (!parsed.is_object()) return "null";
  parsed.erase("config");
  return parsed.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

Response tile_response(Result<std::string> tile) {
  if (tile) return {200, "application/octet-stream", std::move(*tile)};
  return {tile.error().code == ErrorCode::kInvalid ? 400 : 404, Response().type, tile.error().message + "\n"};
}

std::string scene_json(const std::string& name, bool is_live, Time begin, const std::string& summary,
                       const std::string& maps, const std::string& scans) {
  return fmt::format(R"({{"format":1,"name":{},"live":{},"begin":"{}","summary":{},"atlas":{},"scans":{}}})",
                     json_text(name), is_live, eval::seconds_text(begin),
                     summary.empty() ? "null" : shorten(summary), maps, scans);
}

Time begin_of(const MapsAndEdges& maps, const Scans& scans) {
  Time begin = scans.scans.empty() ? Time::max() : scans.scans.front().time;
  for (const atlas::MapRow& map : maps.maps) begin = std::min(begin, map.begin);
  return begin == Time::max() ? Time{} : begin;
}

RecordedRun::RecordedRun(const RunFolder& run) : tiles_(run.atlas) {
  const Time begin = begin_of(run.maps, run.scans);
  scene_ = scene_json(run.name, false, begin, run.summary, maps_json(run.maps, begin),
                      scans_json(run.scans, 0, begin));
}

}  // namespace mmlins::view

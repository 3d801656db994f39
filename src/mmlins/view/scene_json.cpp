// SPDX-License-Identifier: MIT
// Columns rather than objects: there may be tens of thousands of rows.

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "mmlins/view/blocks.hpp"
#include "mmlins/view/scene.hpp"

namespace mmlins::view {
namespace {

using nlohmann::json;

/// Appends a JSON list of what `write` says of each row.
template <typename Rows, typename Write>
void list(std::string& text, const char* name, const Rows& rows, const Write& write) {
  fmt::format_to(std::back_inserter(text), "\"{}\":[", name);
  bool is_first = true;
  for (const auto& row : rows) {
    if (!is_first) text += ',';
    is_first = false;
    write(text, row);
  }
  text += ']';
}

void number(std::string& text, double value, int decimals) {
  fmt::format_to(std::back_inserter(text), "{:.{}f}", value, decimals);
}

/// x, y, z, qx, qy, qz, qw without brackets.
void pose(std::string& text, const math::SE3& T) {
  const Eigen::Quaterniond q = T.quaternion();
  fmt::format_to(std::back_inserter(text), "{:.4f},{:.4f},{:.4f},{:.7f},{:.7f},{:.7f},{:.7f}", T.t.x(),
                 T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w());
}

double since(Time time, Time begin) { return to_seconds(time - begin); }

/// Evidence is JSON already; what cannot be read is told as text.
std::string evidence(const std::string& text) {
  const json parsed = json::parse(text, nullptr, false);
  return parsed.is_discarded() ? json_text(text)
                               : parsed.dump(-1, ' ', false, json::error_handler_t::replace);
}

void write_map(std::string& text, const atlas::MapRow& map, Time begin) {
  fmt::format_to(
      std::back_inserter(text),
      R"({{"id":{},"world":{},"active":{},"began":{},"ended":{},"begin":{:.3f},"last":{:.3f},"anchor":[)",
      map.id, map.world, map.state == atlas::MapState::kActive, json_text(map.beginning),
      json_text(map.why_ended), since(map.begin, begin), since(map.last, begin));
  pose(text, map.T_world_map);
  text += "]}";
}

void write_keyframes(std::string& text, const std::vector<atlas::KeyframeRow>& rows, Time begin) {
  using Row = atlas::KeyframeRow;
  const auto column = [&](const char* name, const auto& write, const char* end = ",") {
    list(text, name, rows, write);
    text += end;
  };
  text += "\"keyframes\":{";
  column("id", [](std::string& to, const Row& row) { to += std::to_string(row.id); });
  column("map", [](std::string& to, const Row& row) { to += std::to_string(row.map_id); });
  column("points", [](std::string& to, const Row& row) { to += std::to_string(row.num_points); });
  column("t", [&](std::string& to, const Row& row) { number(to, since(row.time, begin), 3); });
  column("odometry", [](std::string& to, const Row& row) { pose(to, row.T_map_imu); });
  column(
      "optimised", [](std::string& to, const Row& row) { pose(to, row.T_map_imu_optimised); }, "}");
}

void write_edge(std::string& text, const atlas::EdgeRow& row) {
  fmt::format_to(
      std::back_inserter(text),
      R"({{"from":{},"to":{},"kind":"{}","weight":{:.3f},"closure":{},"evidence":{},"T_from_to":[)",
      row.edge.from, row.edge.to, graph::kEdgeKindNames[static_cast<std::size_t>(row.edge.kind)], row.weight,
      row.edge.robust ? row.edge.provenance : -1, row.evidence.empty() ? "null" : evidence(row.evidence));
  pose(text, row.edge.T_from_to);
  text += "]}";
}

void write_merge(std::string& text, const atlas::MergeRow& row, Time begin) {
  fmt::format_to(std::back_inserter(text),
                 R"({{"id":{},"t":{:.3f},"map":{},"into":{},"kind":{},"undone":{},"evidence":{},"before":[)",
                 row.id, since(row.time, begin), row.map, row.into, json_text(row.kind), row.undone,
                 row.evidence.empty() ? "null" : evidence(row.evidence));
  pose(text, row.T_before);
  text += "],\"after\":[";
  pose(text, row.T_after);
  text += "]}";
}

}  // namespace

std::string json_text(std::string_view text) {
  return json(text).dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string maps_json(const MapsAndEdges& maps, Time begin) {
  std::string text = "{";
  list(text, "maps", maps.maps,
       [&](std::string& to, const atlas::MapRow& row) { write_map(to, row, begin); });
  text += ',';
  write_keyframes(text, maps.keyframes, begin);
  text += ',';
  list(text, "edges", maps.edges, [](std::string& to, const atlas::EdgeRow& row) { write_edge(to, row); });
  text += ',';
  list(text, "merges", maps.merges,
       [&](std::string& to, const atlas::MergeRow& row) { write_merge(to, row, begin); });
  text += ',';
  list(text, "blocks", make_blocks(maps.keyframes), [](std::string& to, const Block& block) {
    fmt::format_to(std::back_inserter(to), "[{},{},{},{}]", block.map_id, block.first, block.last,
                   block.num_points);
  });
  return text + "}";
}

std::string scans_json(const Scans& scans, std::size_t from, Time begin) {
  const std::span<const SceneScan> rows(
      scans.scans.begin() + static_cast<std::ptrdiff_t>(std::min(from, scans.scans.size())),
      scans.scans.end());
  std::string text = fmt::format(R"({{"from":{},"states":{},"causes":{},)", from,
                                 json(scans.names.states).dump(), json(scans.names.causes).dump());
  const auto column = [&](const char* name, const auto& write, const char* end = ",") {
    list(text, name, rows, write);
    text += end;
  };
  column("t", [&](std::string& to, const SceneScan& scan) { number(to, since(scan.time, begin), 3); });
  column("map", [](std::string& to, const SceneScan& scan) { to += std::to_string(scan.map_id); });
  column("state", [](std::string& to, const SceneScan& scan) { to += std::to_string(scan.state); });
  column("cause", [](std::string& to, const SceneScan& scan) { to += std::to_string(scan.cause); });
  column("ms", [](std::string& to, const SceneScan& scan) { number(to, scan.total_ms, 2); });
  column(
      "pose", [](std::string& to, const SceneScan& scan) { pose(to, scan.T_world_imu); }, "}");
  return text;
}

}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
// Removing a map, and looking whether all is well.

#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/atlas/chunk_file.hpp"
#include "mmlins/atlas/database.hpp"
#include "mmlins/atlas/row_codec.hpp"
#include "mmlins/atlas/schema.hpp"

namespace mmlins::atlas {
namespace {

Result<std::size_t> count_rows(Database& database, const std::string& source, int map_id) {
  Statement count = database.prepare("SELECT count(*) FROM " + source);
  if (!count.bind(map_id).next()) return count.status().error();
  return static_cast<std::size_t>(count.integer(0));
}

constexpr const char* kKeyframesOfMap = "(SELECT id FROM keyframe WHERE map = ?1)";

/// What goes with a map, in the order of removal: rows before what they refer to.
Result<Removed> remove_rows(Database& database, int map_id) {
  const std::string of_map = kKeyframesOfMap;
  Removed removed;
  std::size_t num_gravity = 0;
  std::size_t num_maps = 0;
  const std::pair<std::string, std::size_t*> sources[] = {
      {"edge WHERE from_keyframe IN " + of_map + " OR to_keyframe IN " + of_map, &removed.num_edges},
      {"gravity WHERE keyframe IN " + of_map, &num_gravity},
      {"place WHERE map = ?1", &removed.num_places},
      {"merge WHERE map = ?1 OR into_map = ?1", &removed.num_merges},
      {"keyframe WHERE map = ?1", &removed.num_keyframes},
      {"map WHERE id = ?1", &num_maps}};
  for (const auto& [source, count] : sources) {
    const auto rows = count_rows(database, source, map_id);
    if (!rows) return rows.error();
    *count = *rows;
    Statement remove = database.prepare("DELETE FROM " + source);
    if (const Status status = remove.bind(map_id).run(); !status) return status.error();
  }
  if (num_maps == 0)
    return make_error(ErrorCode::kNotFound, "{}: there is no map {}", database.path(), map_id);
  // A world has the number of its first map; its frame stays.
  const Status status = database.execute(
      "UPDATE map SET world = (SELECT min(m.id) FROM map AS m WHERE m.world = map.world) "
      "WHERE world NOT IN (SELECT id FROM map)");
  if (!status) return status.error();
  return removed;
}

/// "keyframes 3 to 17": problems of one kind in one line.
struct Lost {
  std::size_t count = 0;
  int first = 0;
  int last = 0;
};

template <typename Row>
void check_rows(Statement statement, std::optional<Row> (*read)(const Statement&), const std::string& what,
                CheckReport& report, const std::function<void(const Row&)>& use) {
  std::size_t num_damaged = 0;
  while (statement.next()) {
    const auto row = read(statement);
    if (row) use(*row);
    if (!row) ++num_damaged;
  }
  if (num_damaged > 0) report.problems.push_back(fmt::format("{}: {} rows are damaged", what, num_damaged));
  if (const Status status = statement.status(); !status) report.problems.push_back(status.error().message);
}

}  // namespace

Result<std::int64_t> Atlas::remove_unused_chunks() {
  std::set<int> used;
  Statement chunks = database_->prepare("SELECT DISTINCT chunk FROM keyframe");
  while (chunks.next()) used.insert(chunks.int32(0));
  if (const Status status = chunks.status(); !status) return status.error();
  std::int64_t freed = 0;
  for (const int chunk : chunks_in(folder_)) {
    if (used.contains(chunk)) continue;
    std::error_code failure;
    const auto size = std::filesystem::file_size(chunk_path(folder_, chunk), failure);
    if (!failure) std::filesystem::remove(chunk_path(folder_, chunk), failure);
    if (failure) {
      return make_error(ErrorCode::kIo, "{}: cannot be removed: {}", chunk_path(folder_, chunk),
                        failure.message());
    }
    freed += static_cast<std::int64_t>(size);
  }
  return freed;
}

Result<Removed> Atlas::delete_map(int map_id) {
  if (const Status status = begin_batch(); !status) return status.error();
  if (const Status status = commit(); !status) return status.error();
  Result<Removed> removed = Removed{};
  {
    Transaction transaction(*database_);
    if (const Status status = transaction.begin(); !status) return status.error();
    removed = remove_rows(*database_, map_id);
    if (!removed) return removed;
    if (const Status status = transaction.commit(); !status) return status.error();
  }
  writer_.reset();  // its file may be among those that go
  const auto freed = remove_unused_chunks();
  if (!freed) return freed.error();
  removed->freed_bytes = *freed;
  return removed;
}

void Atlas::check_points(CheckReport& report) const {
  std::map<std::string, Lost> lost;  // by what is wrong
  const auto check_keyframe = [&](const KeyframeRow& row) {
    const auto keyframe = load_keyframe(row.id);
    const bool is_whole = keyframe.ok() && static_cast<int>(keyframe->points_imu.size()) == row.num_points;
    if (is_whole) {
      report.num_points += keyframe->points_imu.size();
      return;
    }
    std::error_code failure;
    const std::string path = chunk_path(folder_, row.place.chunk);
    const bool is_missing = !std::filesystem::exists(path, failure);
    Lost& entry = lost[path + (is_missing ? ": is missing" : ": has records that are damaged or cut off")];
    if (entry.count++ == 0) entry.first = row.id;
    entry.last = row.id;
  };
  Statement rows = database_->prepare("SELECT * FROM keyframe ORDER BY id");
  check_rows<KeyframeRow>(std::move(rows), read_keyframe, index_path(folder_) + ": keyframes", report,
                          check_keyframe);
  for (const auto& [what, entry] : lost) {
    report.problems.push_back(
        fmt::format("{}: the points of {} keyframe{} ({} to {}) are lost; all others can be used", what,
                    entry.count, entry.count == 1 ? "" : "s", entry.first, entry.last));
  }
  for (const int chunk : chunks_in(folder_)) {
    if (const Status status = check_chunk(folder_, chunk); !status)
      report.problems.push_back(status.error().message);
  }
}

Status Atlas::check_references(CheckReport& report) const {
  const std::pair<const char*, const char*> sources[] = {
      {"keyframe WHERE map NOT IN (SELECT id FROM map)", "keyframes belong to maps that are not there"},
      {"edge WHERE from_keyframe NOT IN (SELECT id FROM keyframe) OR to_keyframe NOT IN (SELECT id FROM "
       "keyframe)",
       "edges join keyframes that are not there"},
      {"place WHERE map NOT IN (SELECT id FROM map)", "places belong to maps that are not there"}};
  for (const auto& [source, what] : sources) {
    Statement count = database_->prepare(std::string("SELECT count(*) FROM ") + source);
    if (!count.next()) return count.status();
    if (count.integer(0) > 0) {
      report.problems.push_back(fmt::format("{}: {} {}", index_path(folder_), count.integer(0), what));
    }
  }
  return {};
}

Result<CheckReport> Atlas::check() const {
  CheckReport report;
  const std::string path = index_path(folder_);
  Statement integrity = database_->prepare("PRAGMA integrity_check(10)");
  while (integrity.next()) {
    if (integrity.text(0) != "ok") report.problems.push_back(fmt::format("{}: {}", path, integrity.text(0)));
  }
  const auto rows = [&](const char* table) {
    return database_->prepare(std::string("SELECT * FROM ") + table);
  };
  check_rows<MapRow>(rows("map"), read_map, path + ": maps", report,
                     [&](const MapRow&) { ++report.num_maps; });
  check_rows<EdgeRow>(rows("edge"), read_edge, path + ": edges", report,
                      [&](const EdgeRow&) { ++report.num_edges; });
  check_rows<PlaceRow>(rows("place"), read_place, path + ": places", report, [](const PlaceRow&) {});
  check_rows<MergeRow>(rows("merge"), read_merge, path + ": merges", report, [](const MergeRow&) {});
  check_rows<GravityRow>(rows("gravity"), read_gravity, path + ": gravity", report, [](const GravityRow&) {});
  Statement count = database_->prepare("SELECT count(*) FROM keyframe");
  if (count.next()) report.num_keyframes = static_cast<std::size_t>(count.integer(0));
  check_points(report);
  if (const Status status = check_references(report); !status)
    report.problems.push_back(status.error().message);
  return report;
}

}  // namespace mmlins::atlas

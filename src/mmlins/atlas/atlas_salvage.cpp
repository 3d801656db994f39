// SPDX-License-Identifier: MIT
// When the index is lost: chunk records say what each keyframe was, and whatever rows of the old index can
// still be read say more.

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/atlas/chunk_file.hpp"
#include "mmlins/atlas/database.hpp"
#include "mmlins/atlas/keyframe_codec.hpp"
#include "mmlins/atlas/row_codec.hpp"
#include "mmlins/atlas/schema.hpp"
#include "mmlins/base/log.hpp"

namespace mmlins::atlas {
namespace {

/// A keyframe is in the index again, with the pose that the odometry gave it.
Status insert_keyframe(Database& database, const RecordPlace& place, ByteView payload) {
  const auto kf = decode_keyframe(payload);
  if (!kf) return {};
  Statement insert = database.prepare("INSERT OR REPLACE INTO keyframe VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
  insert.bind(kf->id)
      .bind(kf->map_id)
      .bind(kf->time)
      .bind(pose_bytes(kf->T_map_imu))
      .bind(pose_bytes(kf->T_map_imu));
  insert.bind(vector_bytes(kf->down_imu)).bind(static_cast<std::int64_t>(kf->points_imu.size()));
  return insert.bind(place.chunk).bind(place.offset).run();
}

Status read_chunks(Database& database, const std::string& folder) {
  Status failed;
  for (const int chunk : chunks_in(folder)) {
    const Status status = scan_records(folder, chunk, [&](const RecordPlace& place, ByteView payload) {
      const Status inserted = insert_keyframe(database, place, payload);
      if (!inserted && failed) failed = inserted;
    });
    if (!status) log::warning("{}", status.error().message);
  }
  return failed;
}

bool is_readable(const Statement& row, std::string_view table) {
  if (table == "map") return read_map(row).has_value();
  if (table == "keyframe") return read_keyframe(row).has_value();
  if (table == "edge") return read_edge(row).has_value();
  if (table == "gravity") return read_gravity(row).has_value();
  if (table == "place") return read_place(row).has_value();
  return read_merge(row).has_value();
}

/// From both ends, as one damaged page hides what lies behind it.
void copy_readable_rows(Database& from, Database& to, std::string_view table) {
  for (const char* order : {"ASC", "DESC"}) {
    Statement rows =
        from.prepare(fmt::format("SELECT * FROM {} NOT INDEXED ORDER BY rowid {}", table, order));
    if (!rows.status()) return;
    std::string marks = "?";
    for (int i = 1; i < rows.num_columns(); ++i) marks += ", ?";
    Statement insert = to.prepare(fmt::format("INSERT OR REPLACE INTO {} VALUES({})", table, marks));
    while (rows.next()) {
      if (!is_readable(rows, table)) continue;
      if (!insert.bind_row(rows).run()) return;
    }
    if (rows.status()) return;
  }
}

/// Maps of which nothing but keyframes is left.
Status add_missing_maps(Database& database) {
  Statement missing = database.prepare(
      "SELECT map, min(time_ns), max(time_ns) FROM keyframe WHERE map NOT IN (SELECT id FROM map) GROUP BY "
      "map");
  while (missing.next()) {
    MapRow map;
    map.id = missing.int32(0);
    map.world = map.id;
    map.state = MapState::kSleeping;
    map.beginning = "unknown";
    map.why_ended = "unknown";
    map.begin = missing.time(1);
    map.last = missing.time(2);
    Statement insert = database.prepare(
        "INSERT INTO map(state, world, beginning, why_ended, begin_ns, last_ns, T_world_map, id) "
        "VALUES(?, ?, ?, ?, ?, ?, ?, ?)");
    if (const Status status = bind_map(insert, map).run(); !status) return status;
  }
  return missing.status();
}

}  // namespace

Result<Atlas> Atlas::salvage(const std::string& folder) {
  const IndexKind kind = identify_index(folder).kind;
  const bool has_old_index = kind == IndexKind::kOurs;
  if (chunks_in(folder).empty() && !has_old_index) {
    return make_error(ErrorCode::kNotFound, "{}: nothing of an atlas is left here", folder);
  }
  auto database = Database::open(index_path(folder), OpenMode::kMemory);
  if (!database) return database.error();
  if (const Status status = (*database)->execute("BEGIN;" + schema_sql()); !status) return status.error();
  if (const Status status = read_chunks(**database, folder); !status) return status.error();
  if (has_old_index) {
    const auto old = Database::open(index_path(folder), OpenMode::kUntouched);
    if (!old) return old.error();
    for (const std::string_view table : kTables) copy_readable_rows(**old, **database, table);
  }
  if (const Status status = add_missing_maps(**database); !status) return status.error();
  if (const Status status = (*database)->execute("COMMIT"); !status) return status.error();
  return Atlas(folder, std::move(database).value(), {});
}

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
// What is read, row by row; damaged rows are left out.

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/atlas/chunk_file.hpp"
#include "mmlins/atlas/database.hpp"
#include "mmlins/atlas/keyframe_codec.hpp"
#include "mmlins/atlas/row_codec.hpp"
#include "mmlins/base/log.hpp"

namespace mmlins::atlas {
namespace {

template <typename Row>
Result<std::vector<Row>> read_rows(const Database& database, Statement statement,
                                   std::optional<Row> (*read)(const Statement&), const char* what) {
  std::vector<Row> rows;
  std::size_t num_damaged = 0;
  while (statement.next()) {
    if (auto row = read(statement)) {
      rows.push_back(std::move(*row));
    } else {
      ++num_damaged;
    }
  }
  if (const Status status = statement.status(); !status) return status.error();
  if (num_damaged > 0) {
    log::warning("{}: {} of {} {} are damaged and left out; mmlins maps check tells more", database.path(),
                 num_damaged, num_damaged + rows.size(), what);
  }
  return rows;
}

}  // namespace

Result<std::vector<MapRow>> Atlas::maps() const {
  return read_rows(*database_, database_->prepare("SELECT * FROM map ORDER BY id"), read_map, "maps");
}

Result<std::vector<KeyframeRow>> Atlas::keyframes() const {
  return read_rows(*database_, database_->prepare("SELECT * FROM keyframe ORDER BY id"), read_keyframe,
                   "keyframes");
}

Result<std::vector<KeyframeRow>> Atlas::keyframes_of(int map_id) const {
  Statement rows = database_->prepare("SELECT * FROM keyframe WHERE map = ? ORDER BY id");
  rows.bind(map_id);
  return read_rows(*database_, std::move(rows), read_keyframe, "keyframes");
}

Result<std::vector<EdgeRow>> Atlas::edges() const {
  return read_rows(*database_, database_->prepare("SELECT * FROM edge ORDER BY id"), read_edge, "edges");
}

Result<std::vector<GravityRow>> Atlas::gravity() const {
  return read_rows(*database_, database_->prepare("SELECT * FROM gravity ORDER BY keyframe"), read_gravity,
                   "directions of gravity");
}

Result<std::vector<PlaceRow>> Atlas::places() const {
  return read_rows(*database_, database_->prepare("SELECT * FROM place ORDER BY map, submap"), read_place,
                   "places");
}

Result<std::vector<MergeRow>> Atlas::merges() const {
  return read_rows(*database_, database_->prepare("SELECT * FROM merge ORDER BY id"), read_merge, "merges");
}

Result<keyframe::Keyframe> Atlas::load_keyframe(int id) const {
  Statement row = database_->prepare("SELECT chunk, offset FROM keyframe WHERE id = ?");
  if (!row.bind(id).next()) {
    if (const Status status = row.status(); !status) return status.error();
    return make_error(ErrorCode::kNotFound, "{}: there is no keyframe {}", folder_, id);
  }
  const RecordPlace place{row.int32(0), row.integer(1)};
  const Result<Bytes> payload = read_record(folder_, place);
  if (!payload) {
    return Error{payload.error().code,
                 fmt::format("{}: the points of keyframe {} are lost", payload.error().message, id)};
  }
  auto keyframe = decode_keyframe(*payload);
  if (keyframe && keyframe->id == id) return std::move(*keyframe);
  return make_error(ErrorCode::kInvalid,
                    "{}: the record at byte {} is not that of keyframe {}, whose points are lost",
                    chunk_path(folder_, place.chunk), place.offset, id);
}

}  // namespace mmlins::atlas

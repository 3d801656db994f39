// SPDX-License-Identifier: MIT
// What is added and changed. Points go into their chunk before the row that refers to them.

#include <algorithm>
#include <filesystem>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/atlas/chunk_file.hpp"
#include "mmlins/atlas/database.hpp"
#include "mmlins/atlas/keyframe_codec.hpp"
#include "mmlins/atlas/row_codec.hpp"

namespace mmlins::atlas {

Status Atlas::begin_batch() {
  if (!lock_) return make_error(ErrorCode::kInvalid, "{}: was opened for reading only", folder_);
  if (has_batch_ && database_->is_in_transaction()) return {};
  if (has_batch_) return commit();  // which tells that the batch is lost
  if (const Status status = database_->execute("BEGIN IMMEDIATE"); !status) return status;
  has_batch_ = true;
  num_pending_ = 0;
  return {};
}

Status Atlas::commit() {
  if (!has_batch_) return {};
  if (!database_->is_in_transaction()) {  // SQLite undoes all of it if a write fails
    has_batch_ = false;
    return make_error(ErrorCode::kIo,
                      "{}: what was added since the last commit is lost, as it could not be written",
                      folder_);
  }
  if (writer_) {
    if (const Status status = writer_->sync(); !status) return status;
  }
  if (const Status status = database_->execute("COMMIT"); !status) return status;
  has_batch_ = false;
  return {};
}

Status Atlas::add_map(const MapRow& map) {
  if (const Status status = begin_batch(); !status) return status;
  Statement insert = database_->prepare(
      "INSERT INTO map(state, world, beginning, why_ended, begin_ns, last_ns, T_world_map, id) "
      "VALUES(?, ?, ?, ?, ?, ?, ?, ?)");
  return bind_map(insert, map).run();
}

Status Atlas::update_map(const MapRow& map) {
  if (const Status status = begin_batch(); !status) return status;
  Statement update = database_->prepare(
      "UPDATE map SET state = ?, world = ?, beginning = ?, why_ended = ?, begin_ns = ?, last_ns = ?, "
      "T_world_map = ? WHERE id = ?");
  return bind_map(update, map).run();
}

Result<RecordPlace> Atlas::append_points(const keyframe::Keyframe& keyframe) {
  const Result<Bytes> payload = encode_keyframe(keyframe);
  if (!payload) return payload.error();
  if (!writer_) {
    Statement last = database_->prepare("SELECT coalesce(max(chunk), -1) FROM keyframe");
    if (!last.next()) return last.status().error();
    const std::vector<int> chunks = chunks_in(folder_);
    const int last_chunk = std::max(last.int32(0), chunks.empty() ? -1 : chunks.back());
    writer_ = std::make_unique<ChunkWriter>(folder_, last_chunk + 1, options_.chunk_bytes);
  }
  return writer_->append(*payload);
}

Status Atlas::add_keyframe(const keyframe::Keyframe& kf) { return add_keyframe(kf, kf.T_map_imu); }

Status Atlas::add_keyframe(const keyframe::Keyframe& kf, const SE3& T_map_imu_optimised) {
  if (const Status status = begin_batch(); !status) return status;
  Statement known = database_->prepare("SELECT 1 FROM keyframe WHERE id = ?");
  if (known.bind(kf.id).next()) {
    return make_error(ErrorCode::kInvalid, "{}: keyframe {} exists already", folder_, kf.id);
  }
  if (!known.status()) return known.status();
  const Result<RecordPlace> place = append_points(kf);
  if (!place) return place.error();
  Statement insert = database_->prepare("INSERT INTO keyframe VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
  insert.bind(kf.id)
      .bind(kf.map_id)
      .bind(kf.time)
      .bind(pose_bytes(kf.T_map_imu))
      .bind(pose_bytes(T_map_imu_optimised));
  insert.bind(vector_bytes(kf.down_imu)).bind(static_cast<std::int64_t>(kf.points_imu.size()));
  insert.bind(place->chunk).bind(place->offset);
  if (const Status status = insert.run(); !status) return status;
  return ++num_pending_ >= options_.batch_keyframes ? commit() : Status();
}

Result<std::int64_t> Atlas::insert_edge(const EdgeRow& row) {
  Statement insert = database_->prepare("INSERT INTO edge VALUES(nullif(?, 0), ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  const graph::Edge& edge = row.edge;
  insert.bind(row.id).bind(edge.from).bind(edge.to).bind(pose_bytes(edge.T_from_to));
  insert.bind(matrix_bytes(edge.information));
  insert.bind(graph::kEdgeKindNames[static_cast<std::size_t>(edge.kind)])
      .bind(edge.robust)
      .bind(edge.provenance);
  if (const Status status = insert.bind(row.weight).bind(row.evidence).run(); !status) return status.error();
  return database_->last_id();
}

Result<std::int64_t> Atlas::add_edge(const EdgeRow& edge) {
  if (const Status status = begin_batch(); !status) return status.error();
  return insert_edge(edge);
}

Status Atlas::set_edge_weight(const EdgeWeight& weight) {
  if (const Status status = begin_batch(); !status) return status;
  return database_->prepare("UPDATE edge SET weight = ? WHERE id = ?")
      .bind(weight.weight)
      .bind(weight.id)
      .run();
}

Status Atlas::add_gravity(const GravityRow& row) {
  if (const Status status = begin_batch(); !status) return status;
  Statement insert = database_->prepare("INSERT INTO gravity VALUES(?, ?, ?)");
  return insert.bind(row.keyframe_id).bind(vector_bytes(row.up_imu)).bind(row.sigma).run();
}

Status Atlas::add_place(const PlaceRow& row) {
  if (const Status status = begin_batch(); !status) return status;
  Statement insert = database_->prepare("INSERT INTO place VALUES(?, ?, ?, ?, ?, ?)");
  insert.bind(row.map_id)
      .bind(row.submap_id)
      .bind(pose_bytes(row.T_map_submap))
      .bind(id_bytes(row.keyframe_ids));
  return insert.bind(static_cast<double>(row.footprint.ground)).bind(structure_bytes(row.footprint)).run();
}

Status Atlas::write_poses(const GraphChange& change) {
  Statement weight = database_->prepare("UPDATE edge SET weight = ? WHERE id = ?");
  for (const EdgeWeight& w : change.weights) {
    if (const Status status = weight.bind(w.weight).bind(w.id).run(); !status) return status;
  }
  Statement pose = database_->prepare("UPDATE keyframe SET T_map_imu_optimised = ? WHERE id = ?");
  for (const PosedId& posed : change.T_map_imu_optimised) {
    if (const Status status = pose.bind(pose_bytes(posed.pose)).bind(posed.id).run(); !status) return status;
  }
  Statement anchor = database_->prepare("UPDATE map SET T_world_map = ? WHERE id = ?");
  for (const PosedId& posed : change.T_world_map) {
    if (const Status status = anchor.bind(pose_bytes(posed.pose)).bind(posed.id).run(); !status)
      return status;
  }
  Statement world = database_->prepare("UPDATE map SET world = ? WHERE id = ?");
  for (const MapWorld& w : change.worlds) {
    if (const Status status = world.bind(w.world).bind(w.map_id).run(); !status) return status;
  }
  return {};
}

Status Atlas::write_merges(const GraphChange& change, Committed& committed) {
  Statement insert = database_->prepare("INSERT INTO merge VALUES(nullif(?, 0), ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const MergeRow& merge : change.new_merges) {
    insert.bind(merge.id).bind(merge.time).bind(merge.map).bind(merge.into).bind(merge.kind);
    insert.bind(merge.evidence);
    insert.bind(pose_bytes(merge.T_before)).bind(pose_bytes(merge.T_after)).bind(merge.undone);
    if (const Status status = insert.run(); !status) return status;
    committed.merge_ids.push_back(static_cast<int>(database_->last_id()));
  }
  Statement undo = database_->prepare(
      "UPDATE merge SET undone = 1, evidence = CASE ?1 WHEN '' THEN evidence ELSE ?1 END WHERE id = ?2");
  for (const UndoneMerge& undone : change.undone_merges) {
    if (const Status status = undo.bind(undone.evidence).bind(undone.id).run(); !status) return status;
  }
  return {};
}

Result<Committed> Atlas::apply(const GraphChange& change) {
  if (const Status status = begin_batch(); !status) return status.error();
  if (const Status status = commit(); !status) return status.error();
  Transaction transaction(*database_);
  if (const Status status = transaction.begin(); !status) return status.error();
  Committed committed;
  if (const Status status = write_merges(change, committed); !status) return status.error();
  for (const EdgeRow& edge : change.new_edges) {
    const auto id = insert_edge(edge);
    if (!id) return id.error();
    committed.edge_ids.push_back(*id);
  }
  if (const Status status = write_poses(change); !status) return status.error();
  if (const Status status = transaction.commit(); !status) return status.error();
  return committed;
}

}  // namespace mmlins::atlas

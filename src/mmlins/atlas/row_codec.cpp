// SPDX-License-Identifier: MIT
#include "mmlins/atlas/row_codec.hpp"

#include <algorithm>

namespace mmlins::atlas {
namespace {

constexpr std::string_view kActive = "active";
constexpr std::string_view kSleeping = "sleeping";

/// Reads columns one after the other and remembers whether all made sense.
class RowReader {
 public:
  explicit RowReader(const Statement& row) : row_(row) {}

  [[nodiscard]] bool ok() const { return ok_; }
  std::int64_t integer() { return row_.integer(column_++); }
  int int32() { return row_.int32(column_++); }
  Time time() { return row_.time(column_++); }
  double real() { return row_.real(column_++); }
  std::string text() { return row_.text(column_++); }
  SE3 pose() {
    ByteReader bytes = blob();
    return whole(bytes, bytes.pose());
  }
  Vector3d vector3() {
    ByteReader bytes = blob();
    return whole(bytes, bytes.vector3());
  }
  math::Matrix6d matrix() {
    ByteReader bytes = blob();
    math::Matrix6d M;
    bytes.numbers(std::span<double>(M.data(), 36));
    return whole(bytes, math::Matrix6d(M.transpose()));
  }
  template <typename Number>
  std::vector<Number> list() {
    const ByteView content = row_.blob(column_).value_or(ByteView{});
    ByteReader bytes = blob();
    return whole(bytes, bytes.list<Number>(content.size() / sizeof(Number)));
  }
  void require(bool condition) { ok_ = ok_ && condition; }

 private:
  ByteReader blob() {
    const auto content = row_.blob(column_++);
    require(content.has_value());
    return ByteReader(content.value_or(ByteView{}));
  }
  template <typename Value>
  Value whole(const ByteReader& bytes, Value value) {
    require(bytes.at_end());
    return value;
  }

  const Statement& row_;
  int column_ = 0;
  bool ok_ = true;
};

template <typename Row>
std::optional<Row> if_ok(const RowReader& reader, Row&& row) {
  if (!reader.ok()) return std::nullopt;
  return std::forward<Row>(row);
}

}  // namespace

Bytes pose_bytes(const SE3& T) {
  ByteWriter writer;
  writer.pose(T);
  return writer.take();
}

Bytes vector_bytes(const Vector3d& v) {
  ByteWriter writer;
  writer.vector3(v);
  return writer.take();
}

Bytes matrix_bytes(const math::Matrix6d& M) {
  const math::Matrix6d row_by_row = M.transpose();
  ByteWriter writer;
  writer.numbers(std::span<const double>(row_by_row.data(), 36));
  return writer.take();
}

Bytes id_bytes(const std::vector<int>& ids) {
  ByteWriter writer;
  for (const int id : ids) writer.number<std::int32_t>(id);
  return writer.take();
}

Bytes structure_bytes(const place::Footprint& footprint) {
  ByteWriter writer;
  for (const place::StructurePoint& point : footprint.structure) {
    writer.number(point.x_cm);
    writer.number(point.y_cm);
    writer.number(point.amount);
  }
  return writer.take();
}

Statement& bind_map(Statement& statement, const MapRow& map) {
  statement.bind(map.state == MapState::kActive ? kActive : kSleeping).bind(map.world);
  statement.bind(map.beginning).bind(map.why_ended).bind(map.begin).bind(map.last);
  return statement.bind(pose_bytes(map.T_world_map)).bind(map.id);
}

std::optional<MapRow> read_map(const Statement& statement) {
  RowReader row(statement);
  MapRow map;
  map.id = row.int32();
  const std::string state = row.text();
  row.require(state == kActive || state == kSleeping);
  map.state = state == kActive ? MapState::kActive : MapState::kSleeping;
  map.world = row.int32();
  map.beginning = row.text();
  map.why_ended = row.text();
  map.begin = row.time();
  map.last = row.time();
  map.T_world_map = row.pose();
  return if_ok(row, std::move(map));
}

std::optional<KeyframeRow> read_keyframe(const Statement& statement) {
  RowReader row(statement);
  KeyframeRow keyframe;
  keyframe.id = row.int32();
  keyframe.map_id = row.int32();
  keyframe.time = row.time();
  keyframe.T_map_imu = row.pose();
  keyframe.T_map_imu_optimised = row.pose();
  keyframe.down_imu = row.vector3();
  keyframe.num_points = row.int32();
  keyframe.place.chunk = row.int32();
  keyframe.place.offset = row.integer();
  return if_ok(row, std::move(keyframe));
}

std::optional<EdgeRow> read_edge(const Statement& statement) {
  RowReader row(statement);
  EdgeRow edge;
  edge.id = row.integer();
  edge.edge.from = row.integer();
  edge.edge.to = row.integer();
  edge.edge.T_from_to = row.pose();
  edge.edge.information = row.matrix();
  const std::string kind = row.text();
  const auto name = std::find(graph::kEdgeKindNames.begin(), graph::kEdgeKindNames.end(), kind);
  row.require(name != graph::kEdgeKindNames.end());
  edge.edge.kind =
      static_cast<graph::EdgeKind>((name - graph::kEdgeKindNames.begin()) % graph::kNumEdgeKinds);
  edge.edge.robust = row.integer() != 0;
  edge.edge.provenance = row.integer();
  edge.weight = row.real();
  edge.evidence = row.text();
  return if_ok(row, std::move(edge));
}

std::optional<GravityRow> read_gravity(const Statement& statement) {
  RowReader row(statement);
  GravityRow gravity;
  gravity.keyframe_id = row.int32();
  gravity.up_imu = row.vector3();
  gravity.sigma = row.real();
  return if_ok(row, std::move(gravity));
}

std::optional<PlaceRow> read_place(const Statement& statement) {
  RowReader row(statement);
  PlaceRow place;
  place.map_id = row.int32();
  place.submap_id = row.int32();
  place.T_map_submap = row.pose();
  place.keyframe_ids = row.list<int>();
  place.footprint.ground = static_cast<float>(row.real());
  const auto numbers = row.list<std::uint16_t>();
  row.require(numbers.size() % 3 == 0);
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    place.footprint.structure.push_back({std::bit_cast<std::int16_t>(numbers[i]),
                                         std::bit_cast<std::int16_t>(numbers[i + 1]), numbers[i + 2]});
  }
  return if_ok(row, std::move(place));
}

std::optional<MergeRow> read_merge(const Statement& statement) {
  RowReader row(statement);
  MergeRow merge;
  merge.id = row.int32();
  merge.time = row.time();
  merge.map = row.int32();
  merge.into = row.int32();
  merge.kind = row.text();
  merge.evidence = row.text();
  merge.T_before = row.pose();
  merge.T_after = row.pose();
  merge.undone = row.integer() != 0;
  return if_ok(row, std::move(merge));
}

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
#include "mmlins/io/lidar_message_edit.hpp"

#include <cmath>
#include <cstring>

#include "mmlins/io/byte_writer.hpp"
#include "mmlins/io/livox_decode.hpp"
#include "mmlins/io/point_cloud2_decode.hpp"
#include "mmlins/io/point_columns.hpp"
#include "mmlins/io/ros_message_types.hpp"
#include "mmlins/io/to_scan.hpp"

namespace mmlins::io {
namespace {

using Buffer = std::vector<std::uint8_t>;

/// A message of either type, taken apart.
struct Parts {
  Time stamp;
  std::vector<const std::uint8_t*> points;  ///< where each begins
  std::uint32_t point_size = 0;             ///< [bytes]
  PointLayout layout;
  PointCloud2View cloud;   ///< of a PointCloud2
  Bytes before_livox_num;  ///< of a Livox message: header and time base
  Bytes livox_id;          ///< of a Livox message: what lies between its two counts of points
};

Result<Parts> parse_cloud(Bytes message, const std::string& time_field) {
  const auto view = parse_point_cloud2(message);
  if (!view.ok()) return view.error();
  Parts parts;
  parts.cloud = *view;
  parts.stamp = view->stamp;
  parts.point_size = view->point_step;
  if (view->num_points() == 0) return parts;
  const auto fields = parse_fields(view->fields);
  if (!fields.ok()) return fields.error();
  const auto layout = resolve_layout(*fields, view->point_step, time_field);
  if (!layout.ok()) return layout.error();
  parts.layout = *layout;
  parts.points.reserve(view->num_points());
  for (std::uint32_t row = 0; row < view->height; ++row) {
    const std::uint8_t* point = view->data.data() + std::size_t{row} * view->row_step;
    for (std::uint32_t column = 0; column < view->width; ++column, point += view->point_step) {
      parts.points.push_back(point);
    }
  }
  return parts;
}

Result<Parts> parse_livox(Bytes message) {
  constexpr std::uint32_t kPointSize = 19;  // uint32 offset_time, float32 x y z, uint8 reflectivity tag line
  constexpr std::size_t kIdSize = 4;        // lidar_id, reserved
  if (const auto decoded = decode_livox(message); !decoded.ok()) return decoded.error();
  ByteReader reader(message);
  Parts parts;
  parts.stamp = reader.header();
  (void)reader.take(8);  // time base
  parts.before_livox_num = message.first(message.size() - reader.rest().size());
  (void)reader.number<std::uint32_t>();
  parts.livox_id = reader.take(kIdSize);
  const auto num_points = reader.number<std::uint32_t>();
  parts.point_size = kPointSize;
  parts.layout.time = PointField{std::string(kLivoxTimeField), FieldType::kUint32, 0};
  parts.layout.x = {"x", FieldType::kFloat32, 4};
  parts.layout.y = {"y", FieldType::kFloat32, 8};
  parts.layout.z = {"z", FieldType::kFloat32, 12};
  for (std::size_t i = 0; i < num_points; ++i) parts.points.push_back(reader.rest().data() + i * kPointSize);
  return parts;
}

Result<Parts> parse(Bytes message, const LidarInfo& info) {
  return is_livox_type(info.type) ? parse_livox(message) : parse_cloud(message, info.time.field);
}

float load_as_float(const std::uint8_t* point, const PointField& field) {
  float value = 0.0F;
  with_type(field.type,
            [&](auto type) { value = static_cast<float>(load<decltype(type)>(point + field.offset)); });
  return value;
}

void store(std::uint8_t* point, const PointField& field, float value) {
  with_type(field.type, [&](auto type) {
    using Value = decltype(type);
    const Value stored =
        std::is_floating_point_v<Value> ? static_cast<Value>(value) : static_cast<Value>(std::lround(value));
    std::memcpy(point + field.offset, &stored, sizeof(Value));
  });
}

Eigen::Vector3f position_of(const std::uint8_t* point, const PointLayout& layout) {
  return {load_as_float(point, layout.x), load_as_float(point, layout.y), load_as_float(point, layout.z)};
}

std::int64_t time_of(const std::uint8_t* point, const PointField& field, std::int64_t nanoseconds_per_unit) {
  std::int64_t time = 0;
  with_type(field.type, [&](auto type) {
    time = to_nanoseconds(load<decltype(type)>(point + field.offset), nanoseconds_per_unit);
  });
  return time;
}

/// Those of points that a LiDAR measured, for what its times count from.
LidarCloud measured_part(const std::vector<Eigen::Vector3f>& points, const std::vector<std::int64_t>& times) {
  LidarCloud cloud;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite() || points[i].isZero(0.0F) || times[i] == kInvalidTime) continue;
    cloud.points.push_back(points[i]);
    cloud.times.push_back(times[i]);
  }
  return cloud;
}

/// The kept points one after the other, those that have moved with their new place.
Buffer points_data(const Parts& parts, const std::vector<std::uint32_t>& kept,
                   const std::vector<Eigen::Vector3f>& points) {
  Buffer data(kept.size() * parts.point_size);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const std::uint8_t* const source = parts.points[kept[i]];
    std::uint8_t* const target = data.data() + i * parts.point_size;
    std::memcpy(target, source, parts.point_size);
    if (!points[i].allFinite() || points[i] == position_of(source, parts.layout)) continue;
    store(target, parts.layout.x, points[i].x());
    store(target, parts.layout.y, points[i].y());
    store(target, parts.layout.z, points[i].z());
  }
  return data;
}

void append(Buffer& buffer, Bytes bytes) { buffer.insert(buffer.end(), bytes.begin(), bytes.end()); }

Buffer cloud_message(Bytes message, const PointCloud2View& cloud, std::uint32_t num_points, Bytes data) {
  constexpr std::size_t kSizes = 8;  // height and width lie right before the fields
  const auto header_size = static_cast<std::size_t>(cloud.fields.data() - message.data()) - kSizes;
  Buffer edited;
  append(edited, message.first(header_size));
  ByteWriter writer(edited);
  writer.number(std::uint32_t{1});
  writer.number(num_points);
  append(edited, cloud.fields);
  writer.number(std::uint8_t{0});  // is_bigendian: others are not read
  writer.number(cloud.point_step);
  writer.number(num_points * cloud.point_step);
  writer.number(static_cast<std::uint32_t>(data.size()));
  append(edited, data);
  append(edited, message.last(1));  // is_dense
  return edited;
}

}  // namespace

Result<MessagePoints> LidarMessageEditor::read(Bytes message) const {
  const auto parts = parse(message, info_);
  if (!parts.ok()) return parts.error();
  MessagePoints result;
  result.stamp = parts->stamp;
  for (const std::uint8_t* point : parts->points) result.points.push_back(position_of(point, parts->layout));
  result.times.assign(result.points.size(), parts->stamp);
  if (!parts->layout.time) return result;
  std::vector<std::int64_t> times;
  for (const std::uint8_t* point : parts->points) {
    times.push_back(time_of(point, *parts->layout.time, nanoseconds_per(info_.time.unit)));
  }
  LidarCloud measured = measured_part(result.points, times);
  measured.stamp = parts->stamp;
  const Time zero = zero_of_times(std::move(measured), info_.time);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] >= -kMaxPointTime && times[i] <= kMaxPointTime) result.times[i] = zero + Duration(times[i]);
  }
  return result;
}

Result<std::vector<std::uint8_t>> LidarMessageEditor::rewrite(
    Bytes message, const std::vector<std::uint32_t>& kept, const std::vector<Eigen::Vector3f>& points) const {
  const auto parts = parse(message, info_);
  if (!parts.ok()) return parts.error();
  MMLINS_CHECK(kept.size() == points.size() && (kept.empty() || kept.back() < parts->points.size()));
  const Buffer data = points_data(*parts, kept, points);
  const auto num_points = static_cast<std::uint32_t>(kept.size());
  if (!is_livox_type(info_.type)) return cloud_message(message, parts->cloud, num_points, data);
  Buffer edited;
  append(edited, parts->before_livox_num);
  ByteWriter writer(edited);
  writer.number(num_points);
  append(edited, parts->livox_id);
  writer.number(num_points);
  append(edited, data);
  return edited;
}

}  // namespace mmlins::io

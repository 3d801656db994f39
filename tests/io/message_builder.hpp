// SPDX-License-Identifier: MIT
#pragma once
// Serialised messages, put together byte by byte as their definitions say.

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/io/byte_reader.hpp"
#include "mmlins/io/byte_writer.hpp"
#include "mmlins/io/point_field.hpp"

namespace mmlins::io {

using Buffer = std::vector<std::uint8_t>;

inline Bytes bytes_of(const Buffer& buffer) { return {buffer.data(), buffer.size()}; }

/// A value as the bytes of a field of the given type.
inline Buffer encode(FieldType type, double value) {
  Buffer buffer;
  ByteWriter writer(buffer);
  switch (type) {
    case FieldType::kInt8:
      writer.number(static_cast<std::int8_t>(value));
      break;
    case FieldType::kUint8:
      writer.number(static_cast<std::uint8_t>(value));
      break;
    case FieldType::kInt16:
      writer.number(static_cast<std::int16_t>(value));
      break;
    case FieldType::kUint16:
      writer.number(static_cast<std::uint16_t>(value));
      break;
    case FieldType::kInt32:
      writer.number(static_cast<std::int32_t>(value));
      break;
    case FieldType::kUint32:
      writer.number(static_cast<std::uint32_t>(value));
      break;
    case FieldType::kFloat32:
      writer.number(static_cast<float>(value));
      break;
    case FieldType::kFloat64:
      writer.number(value);
      break;
    case FieldType::kInt64:
      writer.number(static_cast<std::int64_t>(value));
      break;
    case FieldType::kUint64:
      writer.number(static_cast<std::uint64_t>(value));
      break;
  }
  return buffer;
}

/// A sensor_msgs/PointCloud2. Every part can be set to something wrong before message().
struct CloudBuilder {
  Time stamp = time_from_ns(1'700'000'000'123'456'789);
  std::uint32_t height = 1;
  std::uint32_t width = 0;
  std::vector<PointField> fields;
  bool is_big_endian = false;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  Buffer data;

  /// Points that have x, y, z as float32 and then the given fields one after the other.
  static CloudBuilder with_fields(std::vector<PointField> extra) {
    CloudBuilder builder;
    builder.fields = {
        {"x", FieldType::kFloat32, 0}, {"y", FieldType::kFloat32, 4}, {"z", FieldType::kFloat32, 8}};
    builder.point_step = 12;
    for (PointField& field : extra) {
      field.offset = builder.point_step;
      builder.point_step += static_cast<std::uint32_t>(encode(field.type, 0.0).size());
      builder.fields.push_back(field);
    }
    return builder;
  }

  /// Appends a point to the only row; one value per field.
  CloudBuilder& add(const std::vector<double>& values) {
    Buffer point(point_step, 0);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Buffer encoded = encode(fields[i].type, values[i]);
      std::memcpy(point.data() + fields[i].offset, encoded.data(), encoded.size());
    }
    data.insert(data.end(), point.begin(), point.end());
    ++width;
    row_step = width * point_step;
    return *this;
  }

  [[nodiscard]] Buffer message() const {
    Buffer buffer;
    ByteWriter writer(buffer);
    writer.header(7, stamp, "lidar");
    writer.number(height);
    writer.number(width);
    writer.number(static_cast<std::uint32_t>(fields.size()));
    for (const PointField& field : fields) {
      writer.text(field.name);
      writer.number(field.offset);
      writer.number(static_cast<std::uint8_t>(field.type));
      writer.number(field.count);
    }
    writer.number(static_cast<std::uint8_t>(is_big_endian));
    writer.number(point_step);
    writer.number(row_step);
    writer.number(static_cast<std::uint32_t>(data.size()));
    buffer.insert(buffer.end(), data.begin(), data.end());
    writer.number(std::uint8_t{1});
    return buffer;
  }
};

/// A sensor_msgs/Imu with recognisable numbers everywhere.
inline Buffer imu_message(Time stamp, const std::vector<double>& gyro, const std::vector<double>& accel) {
  Buffer buffer;
  ByteWriter writer(buffer);
  writer.header(1, stamp, "imu_link");
  for (int i = 0; i < 4 + 9; ++i) writer.number(100.0 + i);
  for (const double value : gyro) writer.number(value);
  for (int i = 0; i < 9; ++i) writer.number(200.0 + i);
  for (const double value : accel) writer.number(value);
  for (int i = 0; i < 9; ++i) writer.number(300.0 + i);
  return buffer;
}

struct LivoxPoint {
  std::uint32_t offset_time;  ///< [ns]
  float x, y, z;
  std::uint8_t reflectivity, tag, line;
};

inline Buffer livox_message(Time stamp, const std::vector<LivoxPoint>& points) {
  Buffer buffer;
  ByteWriter writer(buffer);
  writer.header(1, stamp, "livox_frame");
  writer.number(static_cast<std::uint64_t>(to_ns(stamp)));  // timebase
  writer.number(static_cast<std::uint32_t>(points.size()));
  writer.number(std::uint32_t{0});  // lidar_id and reserved
  writer.number(static_cast<std::uint32_t>(points.size()));
  for (const LivoxPoint& point : points) {
    writer.number(point.offset_time);
    for (const float value : {point.x, point.y, point.z}) writer.number(value);
    for (const std::uint8_t value : {point.reflectivity, point.tag, point.line}) writer.number(value);
  }
  return buffer;
}

}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#include "mmlins/io/rosbag1_writer.hpp"

#include <utility>

#include "mmlins/base/check.hpp"
#include "mmlins/io/byte_writer.hpp"
#include "mmlins/io/point_columns.hpp"
#include "mmlins/io/ros_message_types.hpp"

namespace mmlins::io {
namespace {

// The definitions say what a reader without ROS needs to decode a message; the sums identify them.
constexpr const char* kSeparator =
    "================================================================================\n";
constexpr const char* kHeaderDefinition = "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";

MessageType point_cloud2_type() {
  return {std::string(kPointCloud2Type), "1158d486dd51d683ce2f1be655c3c181",
          std::string("Header header\nuint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\n"
                      "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n") +
              kSeparator + kHeaderDefinition + kSeparator +
              "MSG: sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 "
              "UINT16=4\nuint8 INT32=5\n"
              "uint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\n"
              "uint32 count\n"};
}

MessageType imu_type() {
  return {
      std::string(kImuType), "6a62c6daae103f4ff57a132d6f95cec2",
      std::string("Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
                  "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
                  "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n") +
          kSeparator + kHeaderDefinition + kSeparator +
          "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n" + kSeparator +
          "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"};
}

/// The columns that are written, and the size of a point with them. [bytes]
struct Layout {
  std::vector<PointField> fields{{"x", FieldType::kFloat32, 0},
                                 {"y", FieldType::kFloat32, 4},
                                 {"z", FieldType::kFloat32, 8},
                                 {"intensity", FieldType::kFloat32, 12},
                                 {"time", FieldType::kFloat32, 16}};
  std::uint32_t point_step = 20;
};

Layout layout_for(const sensor::LidarScan& scan) {
  Layout layout;
  if (scan.rings.empty()) return layout;
  layout.fields.push_back({"ring", FieldType::kUint16, 20});
  layout.point_step = 22;
  return layout;
}

template <typename Value>
void store(std::uint8_t* place, Value value) {
  std::memcpy(place, &value, sizeof(Value));
}

void append_points(std::vector<std::uint8_t>& buffer, const sensor::LidarScan& scan,
                   std::uint32_t point_step) {
  std::size_t place = buffer.size();
  buffer.resize(place + scan.size() * point_step);
  for (std::size_t i = 0; i < scan.size(); ++i, place += point_step) {
    std::uint8_t* const point = buffer.data() + place;
    std::memcpy(point, scan.points[i].data(), 12);
    store(point + 12, scan.intensities.empty() ? 0.0F : scan.intensities[i]);
    store(point + 16, scan.offsets[i]);
    if (!scan.rings.empty()) store(point + 20, scan.rings[i]);
  }
}

Status check_stamp(const std::string& topic, Time stamp) {
  if (to_ns(stamp) >= 0 && to_ns(stamp) / 1'000'000'000 <= 0xffffffffLL) return {};
  return make_error(ErrorCode::kInvalid, "{}: stamp {} ns does not fit into a message (1970 to 2106)", topic,
                    to_ns(stamp));
}

void append_vector(ByteWriter& writer, const math::Vector3d& v) {
  for (const double value : {v.x(), v.y(), v.z()}) writer.number(value);
}

/// @param first  of the diagonal; -1 says that there is no measurement at all
void append_covariance(ByteWriter& writer, double first) {
  writer.number(first);
  for (int i = 1; i < 9; ++i) writer.number(0.0);
}

}  // namespace

Result<RosbagWriter> RosbagWriter::create(const std::string& path) {
  auto writer = Rosbag1RawWriter::create(path);
  if (!writer.ok()) return writer.error();
  return RosbagWriter(std::move(*writer));
}

Status RosbagWriter::write_scan(const std::string& topic, const std::string& frame_id,
                                const sensor::LidarScan& scan, Time record_time) {
  MMLINS_CHECK(scan.offsets.size() == scan.size());
  MMLINS_CHECK(scan.intensities.empty() || scan.intensities.size() == scan.size());
  MMLINS_CHECK(scan.rings.empty() || scan.rings.size() == scan.size());
  if (const Status status = check_stamp(topic, scan.start_time); !status.ok()) return status;
  const Layout layout = layout_for(scan);
  buffer_.clear();
  ByteWriter writer(buffer_);
  writer.header(sequence_[topic]++, scan.start_time, frame_id);
  writer.number(std::uint32_t{1});  // height
  writer.number(static_cast<std::uint32_t>(scan.size()));
  writer.number(static_cast<std::uint32_t>(layout.fields.size()));
  for (const PointField& field : layout.fields) {
    writer.text(field.name);
    writer.number(field.offset);
    writer.number(static_cast<std::uint8_t>(field.type));
    writer.number(field.count);
  }
  const auto data_size = static_cast<std::uint32_t>(scan.size() * layout.point_step);
  writer.number(std::uint8_t{0});  // little-endian
  writer.number(layout.point_step);
  writer.number(data_size);  // row_step: all points are in one row
  writer.number(data_size);
  append_points(buffer_, scan, layout.point_step);
  writer.number(std::uint8_t{1});  // dense
  return writer_.write(topic, point_cloud2_type(), record_time, buffer_.data(), buffer_.size());
}

Status RosbagWriter::write_imu(const std::string& topic, const std::string& frame_id,
                               const sensor::ImuSample& sample, Time record_time) {
  if (const Status status = check_stamp(topic, sample.time); !status.ok()) return status;
  buffer_.clear();
  ByteWriter writer(buffer_);
  writer.header(sequence_[topic]++, sample.time, frame_id);
  append_vector(writer, math::Vector3d::Zero());
  writer.number(1.0);
  append_covariance(writer, -1.0);
  append_vector(writer, sample.gyro);
  append_covariance(writer, 0.0);
  append_vector(writer, sample.accel);
  append_covariance(writer, 0.0);
  return writer_.write(topic, imu_type(), record_time, buffer_.data(), buffer_.size());
}

Status RosbagWriter::close() { return writer_.close(); }

}  // namespace mmlins::io

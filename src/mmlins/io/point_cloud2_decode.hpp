// SPDX-License-Identifier: MIT
#pragma once
// sensor_msgs/PointCloud2 from its ROS 1 wire format, with any layout of fields.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/io/byte_reader.hpp"
#include "mmlins/io/lidar_cloud.hpp"
#include "mmlins/io/point_field.hpp"

namespace mmlins::io {

/// The parts of a message; views into its bytes.
struct PointCloud2View {
  Time stamp;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t point_step = 0;  ///< [bytes]
  std::uint32_t row_step = 0;    ///< [bytes]; equal to width * point_step for a single row
  Bytes fields;                  ///< serialised PointField[], as a key for what was made of it before
  Bytes data;

  [[nodiscard]] std::uint64_t num_points() const { return std::uint64_t{width} * height; }
};

/// Where the values lie in a point; resolved once per topic.
struct PointLayout {
  PointField x, y, z;
  std::optional<PointField> intensity;
  std::optional<PointField> ring;
  std::optional<PointField> time;
};

/// Takes a message apart and checks that its sizes agree: every point lies within `data`.
/// Errors do not name the topic, the caller knows it.
[[nodiscard]] Result<PointCloud2View> parse_point_cloud2(Bytes message);

/// The fields of a message that parse_point_cloud2 accepted.
[[nodiscard]] Result<std::vector<PointField>> parse_fields(Bytes fields);

/// Finds x, y, z and the optional fields by their usual names, and checks that they lie within a point.
/// @param time_field  name of the time field; empty: none
[[nodiscard]] Result<PointLayout> resolve_layout(const std::vector<PointField>& fields,
                                                 std::uint32_t point_step, const std::string& time_field);

/// Decodes the messages of one topic.
class PointCloud2Decoder {
 public:
  /// @param nanoseconds_per_unit  of the time field
  PointCloud2Decoder(std::string time_field, std::int64_t nanoseconds_per_unit)
      : time_field_(std::move(time_field)), nanoseconds_per_unit_(nanoseconds_per_unit) {}

  [[nodiscard]] Result<LidarCloud> decode(Bytes message);

 private:
  [[nodiscard]] Status update_layout(const PointCloud2View& view);

  std::string time_field_;
  std::int64_t nanoseconds_per_unit_;
  // The layout, and what it was resolved from.
  PointLayout layout_;
  std::vector<std::uint8_t> layout_fields_;
  std::uint32_t layout_point_step_ = 0;
};

/// Smallest and largest value of the time field over the valid points, in its own unit; nothing if there
/// are no valid points.
[[nodiscard]] std::optional<std::pair<double, double>> time_extremes(const PointCloud2View& view,
                                                                     const PointLayout& layout);

}  // namespace mmlins::io

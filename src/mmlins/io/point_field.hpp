// SPDX-License-Identifier: MIT
#pragma once
// One column of a point cloud message.

#include <cstdint>
#include <string>

namespace mmlins::io {

/// Numbered as in sensor_msgs/PointField, and on as in newer versions of PCL.
enum class FieldType : std::uint8_t {
  kInt8 = 1,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat32,
  kFloat64,
  kInt64,
  kUint64
};

/// As in the message.
struct PointField {
  std::string name;
  FieldType type = FieldType::kFloat32;
  std::uint32_t offset = 0;  ///< [bytes] from the start of a point
  std::uint32_t count = 1;
};

}  // namespace mmlins::io

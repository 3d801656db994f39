// SPDX-License-Identifier: MIT
#pragma once
// Reads one field of many points at a time: the type is looked at once per message, not once per point.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "mmlins/io/lidar_cloud.hpp"
#include "mmlins/io/point_field.hpp"

namespace mmlins::io {

/// [bytes]; 0 for a type that does not exist.
[[nodiscard]] constexpr std::uint32_t size_of(FieldType type) {
  switch (type) {
    case FieldType::kInt8:
    case FieldType::kUint8:
      return 1;
    case FieldType::kInt16:
    case FieldType::kUint16:
      return 2;
    case FieldType::kInt32:
    case FieldType::kUint32:
    case FieldType::kFloat32:
      return 4;
    case FieldType::kInt64:
    case FieldType::kUint64:
    case FieldType::kFloat64:
      return 8;
  }
  return 0;
}

template <typename Value>
[[nodiscard]] Value load(const std::uint8_t* source) {
  Value value;
  std::memcpy(&value, source, sizeof(Value));
  return value;
}

/// Calls body(Value{}) with the C++ type of the field.
template <typename Body>
void with_type(FieldType type, const Body& body) {
  switch (type) {
    case FieldType::kInt8:
      return body(std::int8_t{});
    case FieldType::kUint8:
      return body(std::uint8_t{});
    case FieldType::kInt16:
      return body(std::int16_t{});
    case FieldType::kUint16:
      return body(std::uint16_t{});
    case FieldType::kInt32:
      return body(std::int32_t{});
    case FieldType::kUint32:
      return body(std::uint32_t{});
    case FieldType::kFloat32:
      return body(float{});
    case FieldType::kFloat64:
      return body(double{});
    case FieldType::kInt64:
      return body(std::int64_t{});
    case FieldType::kUint64:
      return body(std::uint64_t{});
  }
}

/// The field of the points that begin at `offsets` [bytes] of `data`, each converted by `convert`.
template <typename Out, typename Convert>
[[nodiscard]] std::vector<Out> read_column(const std::uint8_t* data,
                                           const std::vector<std::uint32_t>& offsets, const PointField& field,
                                           const Convert& convert) {
  std::vector<Out> column(offsets.size());
  with_type(field.type, [&](auto type) {
    using Value = decltype(type);
    const std::uint8_t* const first = data + field.offset;
    for (std::size_t i = 0; i < offsets.size(); ++i) column[i] = convert(load<Value>(first + offsets[i]));
  });
  return column;
}

/// Marks a time that is not a number or too large to be one. [ns]
inline constexpr std::int64_t kInvalidTime = std::numeric_limits<std::int64_t>::min();

/// [ns] of `value` units; exact for integers and rounded to the nearest nanosecond for floating point,
/// also where the product has more digits than a double.
template <typename Value>
[[nodiscard]] std::int64_t to_nanoseconds(Value value, std::int64_t nanoseconds_per_unit) {
  if constexpr (std::is_floating_point_v<Value>) {
    const auto v = static_cast<double>(value);
    const double limit = static_cast<double>(kMaxPointTime) / static_cast<double>(nanoseconds_per_unit);
    if (!(std::abs(v) < limit)) return kInvalidTime;
    const auto whole = static_cast<std::int64_t>(v);
    const double rest = (v - static_cast<double>(whole)) * static_cast<double>(nanoseconds_per_unit);
    return whole * nanoseconds_per_unit + static_cast<std::int64_t>(rest + (rest < 0.0 ? -0.5 : 0.5));
  } else if constexpr (sizeof(Value) < 8) {
    return static_cast<std::int64_t>(value) * nanoseconds_per_unit;  // 32 bits times 1e9 fit
  } else {
    const std::int64_t limit = kMaxPointTime / nanoseconds_per_unit;
    if (std::cmp_greater(value, limit) || std::cmp_less(value, -limit)) return kInvalidTime;
    return static_cast<std::int64_t>(value) * nanoseconds_per_unit;
  }
}

}  // namespace mmlins::io

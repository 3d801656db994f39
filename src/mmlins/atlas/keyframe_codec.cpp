// SPDX-License-Identifier: MIT
#include "mmlins/atlas/keyframe_codec.hpp"

#include <array>
#include <cmath>

namespace mmlins::atlas {
namespace {

using Coordinates = std::array<std::int16_t, 3>;

constexpr int kLargest = 32767;
/// Floating-point numbers have two zeros; this value, which no multiple within reach has, is the negative
/// one.
constexpr std::int16_t kNegativeZero = -32768;

float from_multiple(std::int16_t multiple) {
  if (multiple == kNegativeZero) return -0.0F;
  return static_cast<float>(multiple * keyframe::kPointQuantum);
}

std::optional<std::int16_t> to_multiple(float coordinate) {
  const double multiple = std::round(coordinate / keyframe::kPointQuantum);
  if (!(std::abs(multiple) <= kLargest)) return std::nullopt;
  const bool is_negative_zero = multiple == 0.0 && std::signbit(coordinate);
  const std::int16_t stored = is_negative_zero ? kNegativeZero : static_cast<std::int16_t>(multiple);
  if (std::bit_cast<std::uint32_t>(from_multiple(stored)) != std::bit_cast<std::uint32_t>(coordinate))
    return std::nullopt;
  return stored;
}

std::optional<Coordinates> to_multiples(const Eigen::Vector3f& point) {
  Coordinates multiples{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto multiple = to_multiple(point[static_cast<Eigen::Index>(axis)]);
    if (!multiple) return std::nullopt;
    multiples[axis] = *multiple;
  }
  return multiples;
}

}  // namespace

Result<Bytes> encode_keyframe(const keyframe::Keyframe& kf) {
  if (!kf.intensities.empty() && kf.intensities.size() != kf.points_imu.size()) {
    return make_error(ErrorCode::kInvalid, "keyframe {} has {} points, but {} intensities", kf.id,
                      kf.points_imu.size(), kf.intensities.size());
  }
  ByteWriter writer;
  writer.number<std::int32_t>(kf.id);
  writer.number<std::int32_t>(kf.map_id);
  writer.number<std::int64_t>(to_ns(kf.time));
  writer.pose(kf.T_map_imu);
  writer.vector3(kf.down_imu);
  writer.number(static_cast<std::uint32_t>(kf.points_imu.size()));
  writer.number<std::uint32_t>(kf.intensities.empty() ? 0 : 1);
  std::vector<Coordinates> multiples;
  multiples.reserve(kf.points_imu.size());
  for (const Eigen::Vector3f& point : kf.points_imu) {
    const auto stored = to_multiples(point);
    if (!stored) {
      return make_error(
          ErrorCode::kInvalid,
          "keyframe {}: point ({}, {}, {}) is no whole multiple of {} m within {} m; round it first", kf.id,
          point.x(), point.y(), point.z(), keyframe::kPointQuantum, keyframe::kPointReach);
    }
    multiples.push_back(*stored);
  }
  writer.numbers(std::span<const Coordinates>(multiples));
  writer.numbers(std::span<const std::uint16_t>(kf.intensities));
  return writer.take();
}

std::optional<keyframe::Keyframe> decode_keyframe(ByteView bytes) {
  ByteReader reader(bytes);
  keyframe::Keyframe kf;
  kf.id = reader.number<std::int32_t>();
  kf.map_id = reader.number<std::int32_t>();
  kf.time = time_from_ns(reader.number<std::int64_t>());
  kf.T_map_imu = reader.pose();
  kf.down_imu = reader.vector3();
  const std::size_t num_points = reader.number<std::uint32_t>();
  const bool has_intensities = reader.number<std::uint32_t>() != 0;
  const auto multiples = reader.list<Coordinates>(num_points);
  kf.intensities = reader.list<std::uint16_t>(has_intensities ? num_points : 0);
  if (!reader.at_end()) return std::nullopt;
  kf.points_imu.reserve(num_points);
  for (const Coordinates& c : multiples) {
    kf.points_imu.emplace_back(from_multiple(c[0]), from_multiple(c[1]), from_multiple(c[2]));
  }
  return kf;
}

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
#include "mmlins/io/livox_decode.hpp"

#include "mmlins/io/point_columns.hpp"

namespace mmlins::io {
namespace {

/// uint32 offset_time, float32 x y z, uint8 reflectivity tag line
constexpr std::size_t kPointSize = 19;

bool is_valid(const Eigen::Vector3f& p) { return p.allFinite() && !p.isZero(0.0F); }

}  // namespace

Result<LidarCloud> decode_livox(Bytes message) {
  ByteReader reader(message);
  LidarCloud cloud;
  cloud.stamp = reader.header();
  (void)reader.take(8 + 4 + 1 + 3);  // timebase, point_num, lidar_id, reserved
  const auto num_points = reader.number<std::uint32_t>();
  const Bytes points = reader.take(std::uint64_t{num_points} * kPointSize);
  if (!reader.at_end()) {
    return make_error(ErrorCode::kInvalid, "message of {} bytes does not hold the {} points it announces",
                      message.size(), num_points);
  }
  cloud.points.reserve(num_points);
  cloud.intensities.reserve(num_points);
  cloud.rings.reserve(num_points);
  cloud.times.reserve(num_points);
  for (const std::uint8_t* p = points.data(); p != points.data() + points.size(); p += kPointSize) {
    const Eigen::Vector3f position(load<float>(p + 4), load<float>(p + 8), load<float>(p + 12));
    if (!is_valid(position)) {
      ++cloud.num_invalid;
      continue;
    }
    cloud.points.push_back(position);
    cloud.intensities.push_back(p[16]);
    cloud.rings.push_back(p[18]);
    cloud.times.push_back(load<std::uint32_t>(p));
  }
  return cloud;
}

}  // namespace mmlins::io

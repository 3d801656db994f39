// SPDX-License-Identifier: MIT
#include "mmlins/io/imu_decode.hpp"

namespace mmlins::io {
namespace {

math::Vector3d read_vector(ByteReader& reader) {
  const double x = reader.number<double>();
  const double y = reader.number<double>();
  const double z = reader.number<double>();
  return {x, y, z};
}

constexpr std::size_t kCovarianceSize = 9 * sizeof(double);

}  // namespace

Result<sensor::ImuSample> decode_imu(Bytes message) {
  ByteReader reader(message);
  sensor::ImuSample sample;
  sample.time = reader.header();
  (void)reader.take(4 * sizeof(double) + kCovarianceSize);  // orientation
  sample.gyro = read_vector(reader);
  (void)reader.take(kCovarianceSize);
  sample.accel = read_vector(reader);
  (void)reader.take(kCovarianceSize);
  if (!reader.at_end()) {
    return make_error(ErrorCode::kInvalid, "message of {} bytes is not a sensor_msgs/Imu", message.size());
  }
  return sample;
}

}  // namespace mmlins::io

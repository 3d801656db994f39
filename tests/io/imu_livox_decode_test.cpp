// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>

#include "mmlins/io/imu_decode.hpp"
#include "mmlins/io/livox_decode.hpp"
#include "tests/io/message_builder.hpp"

namespace mmlins::io {
namespace {

const Time kStamp = time_from_ns(1'700'000'000'999'999'999);
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(ImuDecode, RateAndAccelerationAreFoundBetweenTheCovariances) {
  const auto sample = decode_imu(bytes_of(imu_message(kStamp, {1, 2, 3}, {4, 5, 6})));
  ASSERT_TRUE(sample.ok());
  EXPECT_EQ(sample->time, kStamp);
  EXPECT_EQ(sample->gyro, math::Vector3d(1, 2, 3));
  EXPECT_EQ(sample->accel, math::Vector3d(4, 5, 6));
}

TEST(ImuDecode, EveryOtherLengthIsRefused) {
  Buffer message = imu_message(kStamp, {1, 2, 3}, {4, 5, 6});
  for (std::size_t size = 0; size < message.size(); ++size) {
    EXPECT_FALSE(decode_imu(Bytes(message).first(size)).ok());
  }
  message.push_back(0);
  EXPECT_FALSE(decode_imu(bytes_of(message)).ok());
}

TEST(LivoxDecode, PointsKeepTheirTimesLinesAndReflectivities) {
  const auto cloud = decode_livox(
      bytes_of(livox_message(kStamp, {{0, 1, 2, 3, 50, 16, 0}, {99'000'000, -4, 5, -6, 255, 0, 5}})));
  ASSERT_TRUE(cloud.ok());
  EXPECT_EQ(cloud->stamp, kStamp);
  ASSERT_EQ(cloud->points.size(), 2U);
  EXPECT_EQ(cloud->points[1], Eigen::Vector3f(-4, 5, -6));
  EXPECT_EQ(cloud->intensities, (std::vector<float>{50, 255}));
  EXPECT_EQ(cloud->rings, (std::vector<std::uint16_t>{0, 5}));
  EXPECT_EQ(cloud->times, (std::vector<std::int64_t>{0, 99'000'000}));
}

TEST(LivoxDecode, BeamsWithoutEchoAreDroppedAndCounted) {
  const auto cloud = decode_livox(bytes_of(
      livox_message(kStamp, {{1, 0, 0, 0, 0, 0, 0}, {2, 1, 0, 0, 0, 0, 1}, {3, kNan, 0, 0, 0, 0, 2}})));
  ASSERT_TRUE(cloud.ok());
  EXPECT_EQ(cloud->num_invalid, 2);
  EXPECT_EQ(cloud->times, (std::vector<std::int64_t>{2}));
}

TEST(LivoxDecode, AnEmptyMessageIsNoError) {
  const auto cloud = decode_livox(bytes_of(livox_message(kStamp, {})));
  ASSERT_TRUE(cloud.ok());
  EXPECT_TRUE(cloud->points.empty());
}

TEST(LivoxDecode, EveryOtherLengthIsRefused) {
  Buffer message = livox_message(kStamp, {{0, 1, 2, 3, 50, 16, 0}, {9, -4, 5, -6, 255, 0, 5}});
  for (std::size_t size = 0; size < message.size(); ++size) {
    EXPECT_FALSE(decode_livox(Bytes(message).first(size)).ok());
  }
  message.push_back(0);
  EXPECT_FALSE(decode_livox(bytes_of(message)).ok());
}

}  // namespace
}  // namespace mmlins::io

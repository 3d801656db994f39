// SPDX-License-Identifier: MIT
// Damaged messages: whatever the bytes are, a decoder answers, within its buffer. Each mutated message
// lies in memory of exactly its own size, so that a build with the address sanitizer sees a byte too far.
#include <gtest/gtest.h>

#include <random>

#include "mmlins/io/imu_decode.hpp"
#include "mmlins/io/livox_decode.hpp"
#include "mmlins/io/point_cloud2_decode.hpp"
#include "mmlins/io/to_scan.hpp"
#include "tests/io/message_builder.hpp"

namespace mmlins::io {
namespace {

constexpr int kMutations = 20'000;

/// Uniform in [0, limit), the same everywhere.
std::size_t below(std::mt19937_64& random, std::size_t limit) { return random() % limit; }

/// Overwrites some bytes, mostly with extreme values, and sometimes cuts or extends the message.
Buffer mutate(Buffer message, std::mt19937_64& random) {
  constexpr std::uint8_t kExtremes[] = {0x00, 0xff, 0x7f, 0x80, 0x01};
  const std::size_t num_changes = 1 + below(random, 6);
  for (std::size_t i = 0; i < num_changes; ++i) {
    const bool is_extreme = below(random, 2) == 0;
    message[below(random, message.size())] =
        is_extreme ? kExtremes[below(random, 5)] : static_cast<std::uint8_t>(random());
  }
  if (below(random, 4) == 0) message.resize(below(random, message.size()) + 1);
  if (below(random, 16) == 0) message.resize(message.size() + below(random, 40));
  return Buffer(message.begin(), message.end());  // capacity without reserve
}

/// @return how many of the mutated messages were still accepted
template <typename Decode>
int fuzz(const Buffer& message, std::uint64_t seed, const Decode& decode) {
  std::mt19937_64 random(seed);
  int num_accepted = 0;
  for (int i = 0; i < kMutations; ++i) num_accepted += decode(bytes_of(mutate(message, random))) ? 1 : 0;
  return num_accepted;
}

bool is_consistent(const LidarCloud& cloud) {
  const auto fits = [&cloud](std::size_t size) { return size == 0 || size == cloud.points.size(); };
  bool ok = fits(cloud.intensities.size()) && fits(cloud.rings.size()) && fits(cloud.times.size());
  for (const auto& p : cloud.points) ok = ok && p.allFinite();
  for (const TimeOrigin origin : {TimeOrigin::kStamp, TimeOrigin::kEpoch, TimeOrigin::kOwnClock}) {
    PointTimeModel model;
    model.origin = origin;
    const sensor::LidarScan scan = to_scan(cloud, model, Duration(5));
    ok = ok && scan.end_time >= scan.start_time && scan.offsets.size() == scan.size();
  }
  return ok;
}

TEST(DecodeFuzz, MutatedPointCloud2IsRefusedOrConsistent) {
  auto builder = CloudBuilder::with_fields(
      {{"intensity", FieldType::kFloat32}, {"ring", FieldType::kUint16}, {"time", FieldType::kFloat64}});
  for (int i = 1; i < 9; ++i) builder.add({1.0 * i, 2, 3, 4, 5, 0.01 * i});
  PointCloud2Decoder decoder("time", 1'000'000'000);
  const int accepted = fuzz(builder.message(), 1, [&decoder](Bytes message) {
    const auto cloud = decoder.decode(message);
    EXPECT_TRUE(!cloud.ok() || is_consistent(*cloud));
    return cloud.ok();
  });
  EXPECT_GT(accepted, kMutations / 20);  // otherwise the mutations would test the first check alone
  EXPECT_LT(accepted, kMutations);
}

TEST(DecodeFuzz, MutatedLivoxMessageIsRefusedOrConsistent) {
  std::vector<LivoxPoint> points(12, {1'000, 1.0F, 2.0F, 3.0F, 4, 5, 6});
  const int accepted = fuzz(livox_message(Time{}, points), 2, [](Bytes message) {
    const auto cloud = decode_livox(message);
    EXPECT_TRUE(!cloud.ok() || is_consistent(*cloud));
    return cloud.ok();
  });
  EXPECT_GT(accepted, kMutations / 20);
  EXPECT_LT(accepted, kMutations);
}

TEST(DecodeFuzz, MutatedImuMessageIsRefusedOrRead) {
  const int accepted = fuzz(imu_message(Time{}, {1, 2, 3}, {4, 5, 6}), 3,
                            [](Bytes message) { return decode_imu(message).ok(); });
  EXPECT_GT(accepted, kMutations / 20);
  EXPECT_LT(accepted, kMutations);
}

}  // namespace
}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#include "mmlins/io/point_cloud2_decode.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/io/message_builder.hpp"

namespace mmlins::io {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::int64_t kSeconds = 1'000'000'000;

constexpr FieldType kAllTypes[] = {
    FieldType::kInt8,   FieldType::kUint8, FieldType::kInt16,  FieldType::kUint16,  FieldType::kInt32,
    FieldType::kUint32, FieldType::kInt64, FieldType::kUint64, FieldType::kFloat32, FieldType::kFloat64};

LidarCloud decode(const Buffer& message, const std::string& time_field = "", std::int64_t unit = kSeconds) {
  PointCloud2Decoder decoder(time_field, unit);
  auto cloud = decoder.decode(bytes_of(message));
  EXPECT_TRUE(cloud.ok()) << cloud.error().message;
  return cloud.ok() ? std::move(cloud).value() : LidarCloud{};
}

std::string error_of(const Buffer& message, const std::string& time_field = "") {
  PointCloud2Decoder decoder(time_field, kSeconds);
  const auto cloud = decoder.decode(bytes_of(message));
  EXPECT_FALSE(cloud.ok());
  return cloud.ok() ? "" : cloud.error().message;
}

CloudBuilder two_points() {
  return CloudBuilder::with_fields({{"intensity", FieldType::kFloat32}})
      .add({1, 2, 3, 10})
      .add({4, 5, 6, 20});
}

TEST(PointCloud2Decode, PointsComeInTheOrderOfTheMessage) {
  const CloudBuilder builder = two_points();
  const LidarCloud cloud = decode(builder.message());
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.stamp, builder.stamp);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(4, 5, 6));
  EXPECT_EQ(cloud.intensities, (std::vector<float>{10, 20}));
  EXPECT_TRUE(cloud.rings.empty());
  EXPECT_TRUE(cloud.times.empty());
  EXPECT_EQ(cloud.num_invalid, 0);
}

TEST(PointCloud2Decode, EveryTypeIsReadForEveryField) {
  for (const FieldType type : kAllTypes) {
    CloudBuilder builder;
    for (const char* name : {"ring", "z", "intensity", "x", "time", "y"}) {
      builder.fields.push_back({name, type, builder.point_step});
      builder.point_step += static_cast<std::uint32_t>(encode(type, 0.0).size());
    }
    builder.add({5, 30, 7, 10, 9, 20});
    const LidarCloud cloud = decode(builder.message(), "time", 1000);
    ASSERT_EQ(cloud.points.size(), 1U) << static_cast<int>(type);
    EXPECT_EQ(cloud.points[0], Eigen::Vector3f(10, 20, 30));
    EXPECT_EQ(cloud.intensities[0], 7.0F);
    EXPECT_EQ(cloud.rings[0], 5);
    EXPECT_EQ(cloud.times[0], 9000);
  }
}

TEST(PointCloud2Decode, PaddingAndUnknownFieldsAreSkipped) {
  CloudBuilder builder;
  builder.fields = {{"z", FieldType::kFloat32, 40},
                    {"normal", FieldType::kFloat64, 8, 3},
                    {"x", FieldType::kFloat32, 4},
                    {"y", FieldType::kFloat32, 36}};
  builder.point_step = 48;
  builder.add({3, 99, 1, 2});
  EXPECT_EQ(decode(builder.message()).points[0], Eigen::Vector3f(1, 2, 3));
}

TEST(PointCloud2Decode, RowsBeginWhereTheRowStepSays) {
  CloudBuilder builder = two_points();
  builder.data.insert(builder.data.end(), 5, 0xff);  // padding at the end of the row
  const Buffer row = builder.data;
  builder.data.insert(builder.data.end(), row.begin(), row.end());
  builder.height = 2;
  builder.row_step = static_cast<std::uint32_t>(row.size());
  const LidarCloud cloud = decode(builder.message());
  ASSERT_EQ(cloud.points.size(), 4U);
  EXPECT_EQ(cloud.points[2], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.points[3], Eigen::Vector3f(4, 5, 6));
}

TEST(PointCloud2Decode, RowStepOfASingleRowDoesNotMatter) {
  CloudBuilder builder = two_points();
  builder.row_step = 0;
  EXPECT_EQ(decode(builder.message()).points.size(), 2U);
}

TEST(PointCloud2Decode, InvalidPointsAreDroppedAndCounted) {
  auto builder = CloudBuilder::with_fields({{"intensity", FieldType::kUint8}, {"ring", FieldType::kUint16}});
  builder.add({kNan, 0, 0, 1, 1}).add({1, 0, 0, 2, 2}).add({0, kInf, 0, 3, 3}).add({0, 0, 0, 4, 4});
  builder.add({0, -kInf, kInf, 5, 5}).add({0, 0, -1e30, 6, 6}).add({0, 0, 1e-30, 7, 7});
  const LidarCloud cloud = decode(builder.message());
  EXPECT_EQ(cloud.num_invalid, 4);
  EXPECT_EQ(cloud.intensities, (std::vector<float>{2, 6, 7}));
  EXPECT_EQ(cloud.rings, (std::vector<std::uint16_t>{2, 6, 7}));
}

TEST(PointCloud2Decode, PointsWithoutAUsableTimeAreDroppedAndCounted) {
  auto builder = CloudBuilder::with_fields({{"time", FieldType::kFloat64}, {"ring", FieldType::kUint8}});
  builder.add({1, 0, 0, kNan, 1}).add({1, 0, 0, 0.5, 2}).add({1, 0, 0, 1e300, 3}).add({1, 0, 0, -kInf, 4});
  const LidarCloud cloud = decode(builder.message(), "time");
  EXPECT_EQ(cloud.num_invalid, 3);
  EXPECT_EQ(cloud.points.size(), 1U);
  EXPECT_EQ(cloud.rings, (std::vector<std::uint16_t>{2}));
  EXPECT_EQ(cloud.times, (std::vector<std::int64_t>{500'000'000}));
}

TEST(PointCloud2Decode, AbsoluteSecondsAsDoubleKeepTheirNanoseconds) {
  auto builder = CloudBuilder::with_fields({{"timestamp", FieldType::kFloat64}});
  const double seconds = 1'700'000'000.0 + 0.25;  // exact in binary, its product with 1e9 is not
  builder.add({1, 0, 0, seconds}).add({1, 0, 0, -0.1});
  EXPECT_EQ(decode(builder.message(), "timestamp").times,
            (std::vector<std::int64_t>{1'700'000'000'250'000'000, -100'000'000}));
}

TEST(PointCloud2Decode, AbsoluteNanosecondsAsIntegersAreExact) {
  auto builder = CloudBuilder::with_fields({{"t", FieldType::kUint64}});
  builder.add({1, 0, 0, 0});
  const std::uint64_t time = 1'700'000'000'123'456'789;
  std::memcpy(builder.data.data() + 12, &time, sizeof(time));
  EXPECT_EQ(decode(builder.message(), "t", 1).times[0], 1'700'000'000'123'456'789);
}

TEST(PointCloud2Decode, AnEmptyCloudIsNoError) {
  CloudBuilder builder;
  EXPECT_EQ(decode(builder.message()).points.size(), 0U);
  builder.height = 0;
  builder.width = 1000;
  EXPECT_EQ(decode(builder.message()).stamp, builder.stamp);
}

TEST(PointCloud2Decode, ALayoutThatChangesIsFollowed) {
  PointCloud2Decoder decoder("", 1);
  ASSERT_TRUE(decoder.decode(bytes_of(two_points().message())).ok());
  CloudBuilder other;
  other.fields = {
      {"z", FieldType::kFloat32, 0}, {"y", FieldType::kFloat32, 4}, {"x", FieldType::kFloat32, 8}};
  other.point_step = 16;
  other.add({3, 2, 1});
  const auto cloud = decoder.decode(bytes_of(other.message()));
  ASSERT_TRUE(cloud.ok());
  EXPECT_EQ(cloud->points[0], Eigen::Vector3f(1, 2, 3));
}

TEST(PointCloud2Decode, BigEndianIsRefused) {
  CloudBuilder builder = two_points();
  builder.is_big_endian = true;
  EXPECT_NE(error_of(builder.message()).find("big-endian"), std::string::npos);
}

TEST(PointCloud2Decode, SizesThatDoNotAgreeAreRefused) {
  const auto refused = [](auto change) {
    CloudBuilder builder = two_points();
    change(builder);
    EXPECT_NE(error_of(builder.message()), "");
  };
  refused([](CloudBuilder& b) { b.width = 3; });
  refused([](CloudBuilder& b) { b.width = 0xffffffff; });
  refused([](CloudBuilder& b) { b.height = 2; });
  refused([](CloudBuilder& b) { b.point_step = 17; });
  refused([](CloudBuilder& b) { b.point_step = 0; });
  refused([](CloudBuilder& b) { b.height = 2, b.row_step = 31; });
  // Each product fits into 64 bits, their sum does not.
  refused([](CloudBuilder& b) { b.height = b.width = b.row_step = b.point_step = 0xffffffff; });
  refused([](CloudBuilder& b) { b.point_step = 15, b.row_step = 30; });  // the last field sticks out
  refused([](CloudBuilder& b) { b.fields[1].offset = 0xffffffff; });
  refused([](CloudBuilder& b) { b.fields[2].type = static_cast<FieldType>(77); });
}

TEST(PointCloud2Decode, AMissingFieldIsNamedWithThoseThatAreThere) {
  CloudBuilder builder = two_points();
  builder.fields[1].name = "w";
  const std::string error = error_of(builder.message());
  EXPECT_NE(error.find("no point field y (fields: x, w, z, intensity)"), std::string::npos) << error;
}

TEST(PointCloud2Decode, ATruncatedMessageIsRefusedAtEveryLength) {
  const Buffer message = two_points().message();
  for (std::size_t size = 0; size < message.size(); ++size) {
    const Buffer cut(message.begin(),
                     message.begin() + static_cast<std::ptrdiff_t>(size));  // no byte to spare
    error_of(cut);
  }
}

TEST(PointCloud2Decode, ThirtyThousandPointsAreOneMessage) {
  auto builder = CloudBuilder::with_fields({{"time", FieldType::kFloat32}});
  for (int i = 0; i < 30'000; ++i) builder.add({1.0 + i, 2, 3, 1e-6 * i});
  const LidarCloud cloud = decode(builder.message(), "time");
  ASSERT_EQ(cloud.points.size(), 30'000U);
  EXPECT_EQ(cloud.points.back().x(), 30'000.0F);
  EXPECT_NEAR(static_cast<double>(cloud.times.back()), 29'999'000.0, 2.0);  // float32 resolves 1.9 ns there
}

}  // namespace
}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
// Units that cannot be right are told once, with the key that corrects them.
#include <gtest/gtest.h>

#include <filesystem>

#include "mmlins/base/log.hpp"
#include "mmlins/io/open_dataset.hpp"
#include "mmlins/io/rosbag1_writer.hpp"

namespace mmlins::io {
namespace {

using sensor::AccelUnit;
using sensor::TimeUnit;

constexpr std::int64_t kStart = 1'700'000'000'000'000'000;  // [ns]
constexpr Duration kPeriod(100'000'000);

class Probe : public testing::Test {
 protected:
  void SetUp() override {
    path_ = (std::filesystem::path(testing::TempDir()) /
             (std::string("probe_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".bag"))
                .string();
    log::set_sink([this](log::Level level, const std::string& message) {
      if (level == log::Level::kWarning) warnings_.push_back(message);
    });
  }
  void TearDown() override {
    log::set_sink({});
    std::filesystem::remove(path_);
  }

  /// What is said about ten scans, one every 0.1 s, and 200 samples.
  std::vector<std::string> warnings_for(double scan_seconds, double accel, const sensor::Rig& rig = {}) {
    write(scan_seconds, accel);
    warnings_.clear();
    const auto info = inspect_recording(path_, rig);
    EXPECT_TRUE(info.ok()) << info.error().message;
    return warnings_;
  }

 private:
  void write(double scan_seconds, double accel) const {
    auto writer = RosbagWriter::create(path_);
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 200; ++i) {
      sensor::ImuSample sample;
      sample.time = time_from_ns(kStart) + i * kPeriod / 20;
      sample.accel = {0.0, 0.6 * accel, 0.8 * accel};
      ASSERT_TRUE(writer->write_imu("/imu", "imu", sample, sample.time).ok());
      if (i % 20 != 0) continue;
      sensor::LidarScan scan;
      scan.start_time = sample.time;
      for (int k = 0; k < 50; ++k) {
        scan.points.emplace_back(1.0F + static_cast<float>(k), 0.0F, 0.0F);
        scan.offsets.push_back(static_cast<float>(scan_seconds * k / 49));
        scan.intensities.push_back(0.0F);
        scan.rings.push_back(0);
      }
      scan.end_time = scan.start_time + from_seconds(scan_seconds);
      ASSERT_TRUE(writer->write_scan("/points", "lidar", scan, sample.time).ok());
    }
    ASSERT_TRUE(writer->close().ok());
  }

  std::string path_;
  std::vector<std::string> warnings_;
};

void expect_one_with(const std::vector<std::string>& warnings, const std::vector<std::string>& words) {
  ASSERT_EQ(warnings.size(), 1U);
  for (const std::string& word : words) {
    EXPECT_NE(warnings[0].find(word), std::string::npos) << word << " in: " << warnings[0];
  }
}

sensor::Rig rig_with(AccelUnit unit) {
  sensor::Rig rig;
  rig.accel_unit = unit;
  return rig;
}

sensor::Rig rig_with(TimeUnit unit) {
  sensor::Rig rig;
  rig.time_unit = unit;
  return rig;
}

TEST_F(Probe, GravityInEitherUnitIsNoCauseToWarn) {
  for (const double accel : {9.81, 1.0, 5.1, 14.9}) EXPECT_TRUE(warnings_for(0.099, accel).empty()) << accel;
}

TEST_F(Probe, AccelerationsFarFromGravityAreToldWithTheKeyToSet) {
  expect_one_with(warnings_for(0.099, 4.9), {"/imu", "4.9 m/s^2", "accel_unit"});
  expect_one_with(warnings_for(0.099, 15.1), {"/imu", "15.1 m/s^2", "accel_unit"});
  expect_one_with(warnings_for(0.099, 0.5), {"/imu", "4.9 m/s^2", "taken as g", "accel_unit"});  // 0.5 g
}

TEST_F(Probe, AWrongAccelUnitOfTheRigIsTold) {
  expect_one_with(warnings_for(0.099, 1.0, rig_with(AccelUnit::kMetresPerSecondSquared)),
                  {"/imu", "1 m/s^2", "accel_unit"});
  expect_one_with(warnings_for(0.099, 9.80665, rig_with(AccelUnit::kStandardGravity)),
                  {"/imu", "96.2 m/s^2", "accel_unit"});
}

TEST_F(Probe, ScansAsLongAsTheirPeriodOrSomewhatOffAreNoCauseToWarn) {
  const sensor::Rig rig = rig_with(TimeUnit::kSeconds);
  for (const double seconds : {0.099, 0.29, 1.1e-4})
    EXPECT_TRUE(warnings_for(seconds, 9.81, rig).empty()) << seconds;
}

TEST_F(Probe, ScansLongerThanThreePeriodsAreToldWithTheKeyToSet) {
  expect_one_with(warnings_for(0.31, 9.81, rig_with(TimeUnit::kSeconds)),
                  {"/points", "field time", "0.31 s", "time_unit"});
}

TEST_F(Probe, ScansShorterThanAThousandthOfAPeriodAreToldWithTheKeyToSet) {
  expect_one_with(warnings_for(9e-5, 9.81, rig_with(TimeUnit::kSeconds)),
                  {"/points", "field time", "9e-05 s", "time_unit"});
  expect_one_with(warnings_for(0.099, 9.81, rig_with(TimeUnit::kMicroseconds)),
                  {"/points", "field time", "time_unit"});
  // Less than a nanosecond is rounded to none.
  expect_one_with(warnings_for(0.099, 9.81, rig_with(TimeUnit::kNanoseconds)),
                  {"/points", "field time", "time_unit"});
}

TEST_F(Probe, ScansTakenInAnInstantAreNoCauseToWarn) { EXPECT_TRUE(warnings_for(0.0, 9.81).empty()); }

}  // namespace
}  // namespace mmlins::io

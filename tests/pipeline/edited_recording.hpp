// SPDX-License-Identifier: MIT
#pragma once
// A small simulated recording in memory, to be spoiled by the tests.

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/math/trajectory.hpp"
#include "mmlins/pipeline/slam_system.hpp"
#include "mmlins/sensor/dataset.hpp"
#include "mmlins/sim/scenario.hpp"

namespace mmlins::pipeline {

using Items = std::vector<sensor::Item>;

struct Recording {
  sensor::Rig rig;
  Items items;
  math::Trajectory truth;
  int num_scans = 0;
};

/// The demo, changed by some settings.
inline Recording simulated(const std::vector<std::string>& settings) {
  const auto config = sim::load_scenario("demo", settings);
  EXPECT_TRUE(config.ok());
  sim::Simulation simulation(*config);
  Recording recording{simulation.rig(), {}, simulation.truth(200.0), 0};
  while (true) {
    auto item = simulation.next();
    if (!item.ok() || std::holds_alternative<sensor::EndOfData>(*item)) return recording;
    recording.num_scans += std::holds_alternative<sensor::LidarScan>(*item);
    recording.items.push_back(std::move(*item));
  }
}

/// Eight seconds in the hall of the demo, the first two at rest, with some 2000 points per scan.
inline const Recording& recording() {
  static const Recording made =
      simulated({"duration=8", "trajectory.stand_still=2", "sensor.columns=160", "sensor.model=vlp16"});
  return made;
}

/// Reads items from memory; fails after the last one if told to.
class MemoryDataset final : public sensor::Dataset {
 public:
  explicit MemoryDataset(Items items, std::string error = "")
      : items_(std::move(items)), error_(std::move(error)) {}

  [[nodiscard]] Result<sensor::Item> next() override {
    if (position_ < items_.size()) return items_[position_++];
    if (!error_.empty()) return make_error(ErrorCode::kIo, "{}", error_);
    return sensor::Item(sensor::EndOfData{});
  }
  [[nodiscard]] double progress() const override {
    return items_.empty() ? 1.0 : static_cast<double>(position_) / static_cast<double>(items_.size());
  }

 private:
  Items items_;
  std::string error_;
  std::size_t position_ = 0;
};

inline RunResult run_items(Items items, const std::string& error = "", const Observer& observer = {}) {
  MemoryDataset dataset(std::move(items), error);
  return run(dataset, recording().rig, SlamConfig{}, observer);
}

/// The end of the sweep, or the stamp of the sample.
inline Time time_of(const sensor::Item& item) {
  if (const auto* scan = std::get_if<sensor::LidarScan>(&item)) return scan->end_time;
  return std::get<sensor::ImuSample>(item).time;
}
inline bool is_scan(const sensor::Item& item) { return std::holds_alternative<sensor::LidarScan>(item); }

/// After the start of the recording.
inline Time after(double seconds) { return recording().truth.front().time + from_seconds(seconds); }

/// Puts the clock forward (or back) from `from` on.
inline Items with_clock_jump(Time from, Duration jump) {
  Items items = recording().items;
  for (sensor::Item& item : items) {
    if (time_of(item) < from) continue;
    if (auto* scan = std::get_if<sensor::LidarScan>(&item)) {
      scan->start_time += jump;
      scan->end_time += jump;
    } else {
      std::get<sensor::ImuSample>(item).time += jump;
    }
  }
  return items;
}

/// Distance between how far the run says it went from its first scan, and how far it did [m]. Nothing in
/// common between the frames is needed.
inline double error_at(const RunResult& result, const ScanRecord& record, Duration shift = Duration(0)) {
  const auto& truth = recording().truth;
  const auto first = math::pose_at(truth, result.scans.front().time, from_seconds(1.0));
  const auto now = math::pose_at(truth, record.time - shift, from_seconds(1.0));
  if (!first || !now) return std::numeric_limits<double>::infinity();
  const math::SE3 expected = first->inverse() * *now;
  const math::SE3 actual = result.scans.front().T_odom_imu.inverse() * record.T_odom_imu;
  return (expected.t - actual.t).norm();
}

}  // namespace mmlins::pipeline

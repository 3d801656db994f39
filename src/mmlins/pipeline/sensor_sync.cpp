// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/sensor_sync.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "mmlins/base/log.hpp"

namespace mmlins::pipeline {
namespace {

using namespace std::chrono_literals;
// Disorder within a driver stays far below this; a clock that was set goes far beyond.
constexpr Duration kClockJump = 1s;
constexpr Duration kLongestWait = 1s;

Duration distance(Time a, Time b) { return a > b ? a - b : b - a; }

}  // namespace

void SensorSync::add(const sensor::ImuSample& sample) {
  sensor::ImuSample shifted = sample;
  shifted.time += offsets_.back();
  if (newest_imu_ && shifted.time + kClockJump < *newest_imu_) {
    const Duration jump = *newest_imu_ + imu_period_ - shifted.time;
    offsets_.push_back(offsets_.back() + jump);
    shifted.time += jump;
    log::warning("the clock jumped back by {:.3f} s; later stamps are shifted by {:.3f} s so that time goes on",
                 to_seconds(jump - imu_period_), to_seconds(offsets_.back()));
  }
  if (newest_imu_ && shifted.time <= *newest_imu_) {
    ++num_late_imu_samples_;
    return;
  }
  if (newest_imu_ && shifted.time - *newest_imu_ < kClockJump) imu_period_ = shifted.time - *newest_imu_;
  newest_imu_ = shifted.time;
  imu_.push_back(shifted);
}

Duration SensorSync::offset_for(Time time) const {
  if (!newest_imu_) return offsets_.back();
  return *std::min_element(offsets_.rbegin(), offsets_.rend(), [&](Duration a, Duration b) {
    return distance(time + a, *newest_imu_) < distance(time + b, *newest_imu_);
  });
}

void SensorSync::add(sensor::LidarScan scan) {
  const Duration offset = offset_for(scan.end_time);
  scan.start_time += offset;
  scan.end_time += offset;
  scans_.push_back(std::make_shared<const sensor::LidarScan>(std::move(scan)));
}

void SensorSync::drop_scans_from_the_future() {
  const auto is_ahead = [this](Time end) {
    const auto came_later = [&](const auto& scan) { return scan->end_time + kClockJump < end; };
    return newest_imu_ && *newest_imu_ + kClockJump < end && std::any_of(scans_.begin(), scans_.end(), came_later);
  };
  while (!scans_.empty() && is_ahead(scans_.front()->end_time)) {
    if (num_scans_ahead_++ == 0) {
      log::warning("the scan at {:.3f} s is later than the IMU and the scans after it, and is left out",
                   to_seconds(scans_.front()->end_time.time_since_epoch()));
    }
    scans_.pop_front();
  }
}

std::optional<SyncedScan> SensorSync::next() {
  drop_scans_from_the_future();
  if (scans_.empty()) return std::nullopt;
  const Time end = scans_.front()->end_time;
  const bool reached = newest_imu_ && *newest_imu_ >= end;
  const bool waited = distance(scans_.back()->end_time, end) > kLongestWait;
  if (!reached && !waited && !finished_) return std::nullopt;
  SyncedScan synced;
  synced.scan = std::move(scans_.front());
  scans_.pop_front();
  synced.imu = std::exchange(imu_, {});
  return synced;
}

}  // namespace mmlins::pipeline

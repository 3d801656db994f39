// SPDX-License-Identifier: MIT
#include "mmlins/sensor/imu_buffer.hpp"

#include <algorithm>

#include "mmlins/base/check.hpp"

namespace mmlins::sensor {
namespace {
bool earlier(const ImuSample& sample, Time time) { return sample.time < time; }
}  // namespace

ImuAdmission ImuBuffer::add(const ImuSample& sample) {
  if (!samples_.empty() && sample.time <= samples_.back().time) return ImuAdmission::kNotLater;
  samples_.push_back(sample);
  return ImuAdmission::kAccepted;
}

void ImuBuffer::forget_before(Time time) {
  // The last sample before `time` stays: the value at `time` is interpolated from it.
  while (samples_.size() > 1 && samples_[1].time <= time) samples_.pop_front();
}

ImuSample ImuBuffer::sample_at(Time time) const {
  const auto next = std::lower_bound(samples_.begin(), samples_.end(), time, earlier);
  ImuSample result;
  if (next == samples_.end()) {
    result = samples_.back();
  } else if (next == samples_.begin() || next->time == time) {
    result = *next;
  } else {
    const ImuSample& a = *std::prev(next);
    const double s = to_seconds(time - a.time) / to_seconds(next->time - a.time);
    result.gyro = (1.0 - s) * a.gyro + s * next->gyro;
    result.accel = (1.0 - s) * a.accel + s * next->accel;
  }
  result.time = time;
  return result;
}

Duration ImuBuffer::longest_gap(Time begin, Time end) const {
  MMLINS_CHECK(begin <= end);
  auto next = std::lower_bound(samples_.begin(), samples_.end(), begin, earlier);
  Time previous = next == samples_.begin() ? begin : std::prev(next)->time;
  Duration longest{0};
  while (previous < end) {
    const Time until = next == samples_.end() ? end : (next++)->time;
    longest = std::max(longest, until - previous);
    previous = until;
  }
  return longest;
}

ImuSamples ImuBuffer::covering(Time begin, Time end) const {
  MMLINS_CHECK(begin <= end);
  if (samples_.empty()) return {};
  ImuSamples result{sample_at(begin)};
  auto it = std::lower_bound(samples_.begin(), samples_.end(), begin, earlier);
  for (; it != samples_.end() && it->time < end; ++it) {
    if (it->time > begin) result.push_back(*it);
  }
  if (end > begin) result.push_back(sample_at(end));
  return result;
}

}  // namespace mmlins::sensor

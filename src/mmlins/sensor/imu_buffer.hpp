// SPDX-License-Identifier: MIT
#pragma once
// IMU samples in time order, and the stretch between any two times with its ends interpolated.

#include <deque>

#include "mmlins/sensor/imu_sample.hpp"

namespace mmlins::sensor {

enum class ImuAdmission { kAccepted, kNotLater };

class ImuBuffer {
 public:
  /// Appends a sample. One that is not later than the newest is refused: time does not run backwards.
  [[nodiscard]] ImuAdmission add(const ImuSample& sample);
  /// Drops what is no longer needed for any stretch that begins at `time` or later.
  void forget_before(Time time);

  /// Samples that cover [begin, end]: the first exactly at `begin` and the last exactly at `end`, both
  /// interpolated; where the buffer does not reach, its nearest sample is held. Empty if there are none.
  [[nodiscard]] ImuSamples covering(Time begin, Time end) const;

  /// Longest time without a sample that falls into [begin, end] at least in part. Time before the oldest
  /// sample or after the newest counts up to the end of the stretch.
  [[nodiscard]] Duration longest_gap(Time begin, Time end) const;

  [[nodiscard]] bool empty() const { return samples_.empty(); }
  [[nodiscard]] Time oldest() const { return samples_.front().time; }
  [[nodiscard]] Time newest() const { return samples_.back().time; }

 private:
  [[nodiscard]] ImuSample sample_at(Time time) const;

  std::deque<ImuSample> samples_;
};

}  // namespace mmlins::sensor

// SPDX-License-Identifier: MIT
#pragma once
// What every source of measurements looks like to the rest of the program: one item after the other.
// A live node, a bag of another format or a simulator implements the same interface.

#include <variant>

#include "mmlins/base/result.hpp"
#include "mmlins/sensor/imu_sample.hpp"
#include "mmlins/sensor/lidar_scan.hpp"

namespace mmlins::sensor {

/// The source has no more.
struct EndOfData {};

using Item = std::variant<ImuSample, LidarScan, EndOfData>;

class Dataset {
 public:
  virtual ~Dataset() = default;
  /// The next measurement in the order in which it was recorded. An error means that nothing more can
  /// be read (a damaged file); what came before stays valid.
  [[nodiscard]] virtual Result<Item> next() = 0;
  /// How much has been read, in [0, 1].
  [[nodiscard]] virtual double progress() const = 0;
};

}  // namespace mmlins::sensor

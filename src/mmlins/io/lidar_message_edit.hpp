// SPDX-License-Identifier: MIT
#pragma once
// Takes points out of recorded LiDAR messages, or moves them, and leaves every other byte as it was.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/io/byte_reader.hpp"
#include "mmlins/io/recording_info.hpp"

namespace mmlins::io {

/// Every point of a message in its order, also those without an echo.
struct MessagePoints {
  Time stamp;
  std::vector<Eigen::Vector3f> points;  ///< [m]; may be not finite
  std::vector<Time> times;              ///< when each was measured; the stamp if the message does not tell
};

/// Reads and edits the messages of one topic.
class LidarMessageEditor {
 public:
  /// @param info  of the topic, from probe_lidar()
  explicit LidarMessageEditor(LidarInfo info) : info_(std::move(info)) {}

  /// Errors do not name the topic, the caller knows it.
  [[nodiscard]] Result<MessagePoints> read(Bytes message) const;
  /// The message with fewer points. Fields other than x, y and z keep their values; rows of an organised
  /// cloud become a single one.
  /// @param kept    numbers of points, ascending
  /// @param points  where they are now; those that stay where they were keep their bytes
  [[nodiscard]] Result<std::vector<std::uint8_t>> rewrite(Bytes message,
                                                          const std::vector<std::uint32_t>& kept,
                                                          const std::vector<Eigen::Vector3f>& points) const;

 private:
  LidarInfo info_;
};

}  // namespace mmlins::io

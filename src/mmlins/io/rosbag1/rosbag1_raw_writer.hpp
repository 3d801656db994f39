// SPDX-License-Identifier: MIT
#pragma once
// Writes serialised messages into a ROS 1 bag. The bag library hides behind this header, which is why
// it is written in what C++17 and C++20 share.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "mmlins/base/result.hpp"
#include "mmlins/base/time.hpp"

namespace mmlins::io {

/// What a bag records about the type of a topic.
struct MessageType {
  std::string name;
  std::string md5sum;
  std::string definition;
};

/// The file appears under its own name when close() succeeds; until then it has a temporary name, and
/// it is removed if the writer is destroyed before.
class Rosbag1RawWriter {
 public:
  [[nodiscard]] static Result<Rosbag1RawWriter> create(const std::string& path);

  Rosbag1RawWriter(Rosbag1RawWriter&&) noexcept;
  Rosbag1RawWriter& operator=(Rosbag1RawWriter&&) noexcept;
  ~Rosbag1RawWriter();

  /// @param record_time  later than the epoch, before the year 2106
  [[nodiscard]] Status write(const std::string& topic, const MessageType& type, Time record_time,
                             const std::uint8_t* data, std::size_t size);
  [[nodiscard]] Status close();

 private:
  struct Impl;
  explicit Rosbag1RawWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mmlins::io

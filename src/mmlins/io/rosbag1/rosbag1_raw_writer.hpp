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
#include "mmlins/io/rosbag1/rosbag1_connection.hpp"

namespace mmlins::io {

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
  /// For copies: a connection with the header that it has elsewhere. @return its number for write_to()
  [[nodiscard]] std::size_t add_connection(const BagConnection& connection);
  /// The same as write(), through a connection that was added.
  [[nodiscard]] Status write_to(std::size_t connection, Time record_time, const std::uint8_t* data,
                                std::size_t size);
  [[nodiscard]] Status close();

 private:
  struct Impl;
  explicit Rosbag1RawWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#pragma once
// Raw access to ROS 1 bags: which topics, and their messages as bytes in the order of recording.
// Knows nothing about message types. The bag library hides behind this header, which is why it is
// written in what C++17 and C++20 share.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/base/time.hpp"
#include "mmlins/io/rosbag1/rosbag1_connection.hpp"

namespace mmlins::io {

/// One topic of a bag; all its connections of one type taken together.
struct BagTopic {
  std::string name;
  std::string type;  ///< for instance sensor_msgs/Imu
  std::size_t num_messages = 0;
};

/// One message as recorded. `data` stays valid until the reader is moved on or destroyed.
struct RawMessage {
  std::size_t topic = 0;       ///< index into Rosbag1Reader::topics()
  std::size_t connection = 0;  ///< index into Rosbag1Reader::connections()
  Time record_time;       ///< when the recorder received it
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;  ///< [bytes]
};

class Rosbag1Reader {
 public:
  /// Opens a bag and reads its index. Errors name the file: missing, not a bag, truncated, without index.
  [[nodiscard]] static Result<Rosbag1Reader> open(const std::string& path);

  Rosbag1Reader(Rosbag1Reader&&) noexcept;
  Rosbag1Reader& operator=(Rosbag1Reader&&) noexcept;
  ~Rosbag1Reader();

  [[nodiscard]] const std::string& path() const;
  /// In alphabetical order.
  [[nodiscard]] const std::vector<BagTopic>& topics() const;
  /// Topic by topic; a topic has one for each publisher.
  [[nodiscard]] const std::vector<BagConnection>& connections() const;
  [[nodiscard]] std::size_t num_messages() const;
  /// Earliest and latest record time; the epoch if the bag is empty.
  [[nodiscard]] Time start_time() const;
  [[nodiscard]] Time end_time() const;

  /// Record times of all messages of one topic, from the index alone.
  [[nodiscard]] Result<std::vector<Time>> record_times(std::size_t topic) const;

  /// From now on next() gives only messages of these topics, from the start of the bag again.
  [[nodiscard]] Status select(const std::vector<std::size_t>& topics);
  /// The next message by record time; nothing at the end. An error means that the file is damaged here.
  [[nodiscard]] Result<std::optional<RawMessage>> next();

 private:
  struct Impl;
  explicit Rosbag1Reader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mmlins::io

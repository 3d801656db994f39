// SPDX-License-Identifier: MIT
#pragma once
// Builds serialised ROS 1 messages: the counterpart of byte_reader.hpp.

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>
#include <vector>

#include "mmlins/base/time.hpp"

namespace mmlins::io {

class ByteWriter {
 public:
  /// Appends to `buffer`, which must outlive the writer.
  explicit ByteWriter(std::vector<std::uint8_t>& buffer) : buffer_(buffer) {}

  template <typename Number>
  void number(Number value) {
    for (const std::uint8_t byte : std::bit_cast<std::array<std::uint8_t, sizeof(Number)>>(value)) {
      buffer_.push_back(byte);
    }
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    buffer_.insert(buffer_.end(), text.begin(), text.end());
  }
  /// std_msgs/Header. @param stamp  between the years 1970 and 2106
  void header(std::uint32_t sequence, Time stamp, std::string_view frame_id) {
    number(sequence);
    number(static_cast<std::uint32_t>(to_ns(stamp) / 1'000'000'000));
    number(static_cast<std::uint32_t>(to_ns(stamp) % 1'000'000'000));
    text(frame_id);
  }

 private:
  std::vector<std::uint8_t>& buffer_;
};

}  // namespace mmlins::io

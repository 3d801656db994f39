// SPDX-License-Identifier: MIT
#pragma once
// Reads serialised ROS 1 messages front to back: little-endian numbers, strings and arrays with a length
// before them. Never reads beyond the buffer: after the first failure everything reads as zero or empty,
// so that a whole message can be read first and ok() asked once.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "mmlins/base/time.hpp"

namespace mmlins::io {

static_assert(std::endian::native == std::endian::little,
              "messages are little-endian and are copied as they are");

using Bytes = std::span<const std::uint8_t>;

class ByteReader {
 public:
  explicit ByteReader(Bytes bytes) : rest_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }
  /// Everything was read, and nothing failed.
  [[nodiscard]] bool at_end() const { return ok_ && rest_.empty(); }

  /// What has not been read yet.
  [[nodiscard]] Bytes rest() const { return rest_; }

  template <typename Number>
  [[nodiscard]] Number number() {
    Number value{};
    if (const Bytes source = take(sizeof(Number)); !source.empty())
      std::memcpy(&value, source.data(), sizeof(Number));
    return value;
  }
  [[nodiscard]] Bytes take(std::uint64_t num_bytes) {
    if (!ok_ || num_bytes > rest_.size()) {
      ok_ = false;
      return {};
    }
    const Bytes taken = rest_.first(static_cast<std::size_t>(num_bytes));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  /// A 32-bit length, then as many bytes.
  [[nodiscard]] Bytes sized() { return take(number<std::uint32_t>()); }
  [[nodiscard]] std::string_view text() {
    const Bytes bytes = sized();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  /// Seconds and nanoseconds.
  [[nodiscard]] Time time() {
    const auto seconds = number<std::uint32_t>();
    const auto nanoseconds = number<std::uint32_t>();
    return time_from_ns(std::int64_t{seconds} * 1'000'000'000 + nanoseconds);
  }
  /// std_msgs/Header. @return its stamp
  [[nodiscard]] Time header() {
    (void)number<std::uint32_t>();  // sequence number
    const Time stamp = time();
    (void)text();  // frame
    return stamp;
  }

 private:
  Bytes rest_;
  bool ok_ = true;
};

}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#pragma once
// Numbers as bytes, little-endian, with a checksum at the end where they lie in the index. Internal to
// atlas/.

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "mmlins/math/se3.hpp"

namespace mmlins::atlas {

static_assert(std::endian::native == std::endian::little,
              "numbers are little-endian and are copied as they are");

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

class ByteWriter {
 public:
  template <typename Number>
  void number(Number value) {
    numbers(std::span<const Number>(&value, 1));
  }
  template <typename Number>
  void numbers(std::span<const Number> values) {
    const auto* source = reinterpret_cast<const std::uint8_t*>(values.data());
    bytes_.insert(bytes_.end(), source, source + values.size_bytes());
  }
  void vector3(const math::Vector3d& v) { numbers(std::span<const double>(v.data(), 3)); }
  /// The rotation matrix row by row, then the translation.
  void pose(const math::SE3& T) {
    for (int row = 0; row < 3; ++row) vector3(T.R.row(row).transpose());
    vector3(T.t);
  }
  [[nodiscard]] Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// After the first failure everything reads as zero, so that all can be read first and ok() asked once.
class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : rest_(bytes) {}

  /// Everything was read, and nothing failed.
  [[nodiscard]] bool at_end() const { return ok_ && rest_.empty(); }

  template <typename Number>
  [[nodiscard]] Number number() {
    Number value{};
    numbers(std::span<Number>(&value, 1));
    return value;
  }
  template <typename Number>
  void numbers(std::span<Number> values) {
    ok_ = ok_ && rest_.size() >= values.size_bytes();
    if (!ok_ || values.empty()) return;
    std::memcpy(values.data(), rest_.data(), values.size_bytes());
    rest_ = rest_.subspan(values.size_bytes());
  }
  /// As many numbers as said, if that many are left.
  template <typename Number>
  [[nodiscard]] std::vector<Number> list(std::size_t size) {
    ok_ = ok_ && size <= rest_.size() / sizeof(Number);
    std::vector<Number> values(ok_ ? size : 0);
    numbers(std::span<Number>(values));
    return values;
  }
  [[nodiscard]] math::Vector3d vector3() {
    math::Vector3d v = math::Vector3d::Zero();
    numbers(std::span<double>(v.data(), 3));
    return v;
  }
  [[nodiscard]] math::SE3 pose() {
    math::SE3 T;
    for (int row = 0; row < 3; ++row) T.R.row(row) = vector3().transpose();
    T.t = vector3();
    return T;
  }

 private:
  ByteView rest_;
  bool ok_ = true;
};

/// CRC-32 as in zip files.
[[nodiscard]] std::uint32_t checksum(ByteView bytes);

/// The bytes with their checksum behind them.
[[nodiscard]] Bytes sealed(Bytes bytes);
/// The bytes without the checksum; nothing if it is not theirs.
[[nodiscard]] std::optional<ByteView> unsealed(ByteView bytes);

}  // namespace mmlins::atlas

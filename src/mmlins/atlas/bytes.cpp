// SPDX-License-Identifier: MIT
#include "mmlins/atlas/bytes.hpp"

#include <zlib.h>

namespace mmlins::atlas {

std::uint32_t checksum(ByteView bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

Bytes sealed(Bytes bytes) {
  const std::uint32_t sum = checksum(bytes);
  bytes.resize(bytes.size() + sizeof(sum));
  std::memcpy(bytes.data() + bytes.size() - sizeof(sum), &sum, sizeof(sum));
  return bytes;
}

std::optional<ByteView> unsealed(ByteView bytes) {
  std::uint32_t sum = 0;
  if (bytes.size() < sizeof(sum)) return std::nullopt;
  const ByteView content = bytes.first(bytes.size() - sizeof(sum));
  std::memcpy(&sum, bytes.data() + content.size(), sizeof(sum));
  if (sum != checksum(content)) return std::nullopt;
  return content;
}

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
#include "mmlins/atlas/schema.hpp"

#include <cstdint>
#include <cstring>
#include <fstream>

namespace mmlins::atlas {
namespace {

// Poses and other blobs end with their CRC-32: SQLite does not notice flipped bits.
constexpr const char* kTablesSql = R"(
CREATE TABLE map(id INTEGER PRIMARY KEY, state TEXT NOT NULL, world INTEGER NOT NULL, beginning TEXT NOT NULL,
  why_ended TEXT NOT NULL, begin_ns INTEGER NOT NULL, last_ns INTEGER NOT NULL, T_world_map BLOB NOT NULL);
CREATE TABLE keyframe(id INTEGER PRIMARY KEY, map INTEGER NOT NULL, time_ns INTEGER NOT NULL,
  T_map_imu BLOB NOT NULL, T_map_imu_optimised BLOB NOT NULL, down_imu BLOB NOT NULL,
  num_points INTEGER NOT NULL, chunk INTEGER NOT NULL, offset INTEGER NOT NULL);
CREATE INDEX keyframe_map ON keyframe(map);
CREATE TABLE edge(id INTEGER PRIMARY KEY, from_keyframe INTEGER NOT NULL, to_keyframe INTEGER NOT NULL,
  T_from_to BLOB NOT NULL, information BLOB NOT NULL, kind TEXT NOT NULL, robust INTEGER NOT NULL,
  provenance INTEGER NOT NULL, weight REAL NOT NULL, evidence TEXT NOT NULL);
CREATE TABLE gravity(keyframe INTEGER PRIMARY KEY, up_imu BLOB NOT NULL, sigma REAL NOT NULL);
CREATE TABLE place(map INTEGER NOT NULL, submap INTEGER NOT NULL, T_map_submap BLOB NOT NULL,
  keyframes BLOB NOT NULL, ground REAL NOT NULL, structure BLOB NOT NULL, PRIMARY KEY(map, submap));
CREATE TABLE merge(id INTEGER PRIMARY KEY, time_ns INTEGER NOT NULL, map INTEGER NOT NULL,
  into_map INTEGER NOT NULL, kind TEXT NOT NULL, evidence TEXT NOT NULL, T_before BLOB NOT NULL,
  T_after BLOB NOT NULL, undone INTEGER NOT NULL);
)";

constexpr std::string_view kSqliteMagic{"SQLite format 3\0", 16};
// Places in the header of an SQLite file; its numbers are big-endian.
constexpr std::size_t kUserVersionAt = 60;
constexpr std::size_t kApplicationIdAt = 68;
constexpr std::size_t kHeaderSize = 100;

int big_endian(const std::array<char, kHeaderSize>& header, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(header[at + i]);
  return static_cast<int>(value);
}

}  // namespace

std::string index_path(const std::string& folder) { return folder + "/index.sqlite"; }

std::string schema_sql() {
  return fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};", kApplicationId,
                     kFormatVersion) +
         kTablesSql;
}

IndexIdentity identify_index(const std::string& folder) {
  std::ifstream file(index_path(folder), std::ios::binary);
  if (!file) return {IndexKind::kMissing, 0};
  std::array<char, kHeaderSize> header{};
  file.read(header.data(), header.size());
  if (file.gcount() == 0) return {IndexKind::kEmpty, 0};
  const bool is_whole = file.gcount() == static_cast<std::streamsize>(kHeaderSize);
  if (!is_whole || std::string_view(header.data(), kSqliteMagic.size()) != kSqliteMagic) {
    return {IndexKind::kUnknown, 0};
  }
  if (big_endian(header, kApplicationIdAt) != kApplicationId) return {IndexKind::kForeign, 0};
  const int version = big_endian(header, kUserVersionAt);
  return {version > kFormatVersion ? IndexKind::kNewer : IndexKind::kOurs, version};
}

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
#pragma once
// Append-only files of checksummed records: points_0000.chunk and so on. Internal to atlas/.

#include <functional>
#include <string>
#include <vector>

#include "mmlins/atlas/bytes.hpp"
#include "mmlins/atlas/file_handle.hpp"
#include "mmlins/atlas/rows.hpp"
#include "mmlins/base/result.hpp"

namespace mmlins::atlas {

[[nodiscard]] std::string chunk_path(const std::string& folder, int chunk);
/// Whether a file of this name is a chunk; its number, or -1.
[[nodiscard]] int chunk_number(const std::string& file_name);
/// Numbers of the chunk files in a folder, in increasing order.
[[nodiscard]] std::vector<int> chunks_in(const std::string& folder);

/// Writes to files of its own: one that an earlier process left behind is never continued.
class ChunkWriter {
 public:
  /// @param max_bytes  a new file is begun before one gets larger than this
  ChunkWriter(std::string folder, int first_chunk, std::int64_t max_bytes)
      : folder_(std::move(folder)), chunk_(first_chunk - 1), max_bytes_(max_bytes) {}

  /// The record is with the operating system when this returns. Nothing of it is left after an error.
  [[nodiscard]] Result<RecordPlace> append(ByteView payload);
  /// All records so far are on the disk when this returns.
  [[nodiscard]] Status sync();

 private:
  [[nodiscard]] Status begin_file();

  std::string folder_;
  int chunk_;
  std::int64_t max_bytes_;
  std::int64_t size_ = 0;
  FileHandle file_;
  bool is_synced_ = true;
};

/// Whether a file begins like a chunk of this format.
[[nodiscard]] Status check_chunk(const std::string& folder, int chunk);

/// The payload of a record; the error says in words what is wrong with the file.
[[nodiscard]] Result<Bytes> read_record(const std::string& folder, const RecordPlace& place);

/// Calls `use` for all records of a chunk that are whole, also behind damaged ones.
/// @return an error if the file cannot be read or its format is newer
[[nodiscard]] Status scan_records(const std::string& folder, int chunk,
                                  const std::function<void(const RecordPlace&, ByteView)>& use);

}  // namespace mmlins::atlas

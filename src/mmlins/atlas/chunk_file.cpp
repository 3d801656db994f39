// SPDX-License-Identifier: MIT
#include "mmlins/atlas/chunk_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "mmlins/base/text_file.hpp"

namespace mmlins::atlas {
namespace {

constexpr std::array<char, 8> kMagic{'m', 'm', 'l', 'p', 'o', 'i', 'n', 't'};
constexpr std::uint32_t kVersion = 1;
struct FileHeader {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint32_t unused = 0;
};
static_assert(sizeof(FileHeader) == 16);

constexpr std::array<char, 4> kMarker{'K', 'F', 'R', '1'};
struct RecordHeader {
  std::array<char, 4> marker = kMarker;
  std::uint32_t size = 0;  ///< of the payload [bytes]
  std::uint32_t sum = 0;   ///< its checksum
};
static_assert(sizeof(RecordHeader) == 12);

constexpr std::uint32_t kLargestPayload = 1U << 28;

bool write_all(int file, ByteView bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

bool read_all(int file, void* target, std::size_t size, std::int64_t offset) {
  auto* place = static_cast<std::uint8_t*>(target);
  while (size > 0) {
    const ssize_t got = ::pread(file, place, size, offset);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    place += got;
    offset += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Records carry checksums of their own: a header that is damaged takes nothing from them, a newer one does.
Status refuse_newer(const FileHeader& header, const std::string& path) {
  if (header.magic != kMagic || header.version <= kVersion) return {};
  return make_error(ErrorCode::kUnsupported,
                    "{}: has format {}, this program reads up to {}; use a newer mmlins", path,
                    header.version, kVersion);
}

}  // namespace

std::string chunk_path(const std::string& folder, int chunk) {
  return fmt::format("{}/points_{:04}.chunk", folder, chunk);
}

int chunk_number(const std::string& file_name) {
  constexpr std::string_view kPrefix = "points_";
  constexpr std::string_view kSuffix = ".chunk";
  if (!file_name.starts_with(kPrefix) || !file_name.ends_with(kSuffix)) return -1;
  const std::size_t length = file_name.size() - kPrefix.size() - kSuffix.size();
  const std::string digits = file_name.substr(kPrefix.size(), length);
  if (length < 4 || length > 9 || digits.find_first_not_of("0123456789") != std::string::npos) return -1;
  return std::stoi(digits);
}

std::vector<int> chunks_in(const std::string& folder) {
  std::vector<int> chunks;
  std::error_code failure;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failure)) {
    const int chunk = chunk_number(entry.path().filename().string());
    if (chunk >= 0) chunks.push_back(chunk);
  }
  std::sort(chunks.begin(), chunks.end());
  return chunks;
}

Status ChunkWriter::begin_file() {
  if (const Status status = sync(); !status) return status;
  const std::string path = chunk_path(folder_, chunk_ + 1);
  FileHandle file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file.is_open()) return cannot_write(path, errno);
  const auto header = std::bit_cast<std::array<std::uint8_t, sizeof(FileHeader)>>(FileHeader{});
  if (!write_all(file.get(), header)) {
    const Error error = cannot_write(path, errno);
    ::unlink(path.c_str());
    return error;
  }
  file_ = std::move(file);
  ++chunk_;
  size_ = sizeof(FileHeader);
  return {};
}

Result<RecordPlace> ChunkWriter::append(ByteView payload) {
  MMLINS_CHECK(payload.size() <= kLargestPayload);
  const auto record_size = static_cast<std::int64_t>(sizeof(RecordHeader) + payload.size());
  if (!file_.is_open() || size_ + record_size > max_bytes_) {
    if (const Status status = begin_file(); !status) return status.error();
  }
  const RecordHeader header{kMarker, static_cast<std::uint32_t>(payload.size()), checksum(payload)};
  const auto head = std::bit_cast<std::array<std::uint8_t, sizeof(RecordHeader)>>(header);
  if (!write_all(file_.get(), head) || !write_all(file_.get(), payload)) {
    const Error error = cannot_write(chunk_path(folder_, chunk_), errno);
    // What cannot be cut off again is followed by a new file.
    const bool is_cut =
        ::ftruncate(file_.get(), size_) == 0 && ::lseek(file_.get(), size_, SEEK_SET) == size_;
    if (!is_cut) size_ = max_bytes_;
    return error;
  }
  const RecordPlace place{chunk_, size_};
  size_ += record_size;
  is_synced_ = false;
  return place;
}

Status ChunkWriter::sync() {
  if (is_synced_) return {};
  if (::fdatasync(file_.get()) != 0) return cannot_write(chunk_path(folder_, chunk_), errno);
  is_synced_ = true;
  return {};
}

Result<Bytes> read_record(const std::string& folder, const RecordPlace& place) {
  const std::string path = chunk_path(folder, place.chunk);
  const FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) {
    if (errno == ENOENT)
      return make_error(ErrorCode::kNotFound, "{}: is missing; put it back if you can", path);
    return make_error(ErrorCode::kIo, "{}: cannot be read: {}", path, std::strerror(errno));
  }
  FileHeader file_header;
  if (!read_all(file.get(), &file_header, sizeof(file_header), 0)) file_header.magic = {};
  if (const Status status = refuse_newer(file_header, path); !status) return status.error();
  RecordHeader header;
  if (!read_all(file.get(), &header, sizeof(header), place.offset)) {
    return make_error(ErrorCode::kInvalid, "{}: is cut off before byte {}", path, place.offset);
  }
  const bool is_header = header.marker == kMarker && header.size <= kLargestPayload;
  Bytes payload(is_header ? header.size : 0);
  const auto begin = place.offset + static_cast<std::int64_t>(sizeof(header));
  if (is_header && !read_all(file.get(), payload.data(), payload.size(), begin)) {
    return make_error(ErrorCode::kInvalid, "{}: is cut off within the record at byte {}", path, place.offset);
  }
  if (!is_header || checksum(payload) != header.sum) {
    return make_error(ErrorCode::kInvalid, "{}: the record at byte {} is damaged", path, place.offset);
  }
  return payload;
}

Status check_chunk(const std::string& folder, int chunk) {
  const std::string path = chunk_path(folder, chunk);
  const FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  FileHeader header{.magic = {}};
  if (!file.is_open() || !read_all(file.get(), &header, sizeof(header), 0)) header.magic = {};
  if (const Status status = refuse_newer(header, path); !status) return status;
  if (header.magic == kMagic) return {};
  return make_error(ErrorCode::kInvalid, "{}: is damaged at its beginning, or no chunk file", path);
}

Status scan_records(const std::string& folder, int chunk,
                    const std::function<void(const RecordPlace&, ByteView)>& use) {
  const std::string path = chunk_path(folder, chunk);
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  FileHeader file_header{.magic = {}};
  if (text->size() >= sizeof(file_header)) std::memcpy(&file_header, text->data(), sizeof(file_header));
  if (const Status status = refuse_newer(file_header, path); !status) return status;
  const std::string_view marker(kMarker.data(), kMarker.size());
  for (std::size_t at = text->find(marker); at != std::string::npos;) {
    RecordHeader header;
    const std::size_t left = text->size() - at;
    bool is_whole = left >= sizeof(header);
    if (is_whole) {
      std::memcpy(&header, text->data() + at, sizeof(header));
      is_whole = header.size <= left - sizeof(header);
    }
    std::size_t next = at + 1;
    if (is_whole) {
      const auto* begin = reinterpret_cast<const std::uint8_t*>(text->data()) + at + sizeof(header);
      const ByteView payload(begin, header.size);
      if (checksum(payload) == header.sum) {
        use({chunk, static_cast<std::int64_t>(at)}, payload);
        next = at + sizeof(header) + header.size;
      }
    }
    at = text->find(marker, next);
  }
  return {};
}

}  // namespace mmlins::atlas

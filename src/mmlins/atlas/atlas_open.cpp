// SPDX-License-Identifier: MIT
// How an atlas is made, opened and let go.

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/atlas/chunk_file.hpp"
#include "mmlins/atlas/database.hpp"
#include "mmlins/atlas/schema.hpp"
#include "mmlins/base/log.hpp"

namespace mmlins::atlas {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockName = "writer.lock";

/// Held until the process ends, however it ends.
Result<FileHandle> lock_for_writing(const std::string& folder) {
  const std::string path = folder + "/" + kLockName;
  FileHandle file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!file.is_open())
    return make_error(ErrorCode::kIo, "{}: cannot be written: {}", path, std::strerror(errno));
  if (::flock(file.get(), LOCK_EX | LOCK_NB) == 0) return file;
  return make_error(ErrorCode::kIo, "{}: another process is writing this atlas; wait until it ends", folder);
}

bool is_name_of_ours(const std::string& name) {
  return name == kLockName || name.starts_with("index.sqlite") || chunk_number(name) >= 0;
}

/// Only what is ours may be overwritten.
Status check_replaceable(const std::string& folder) {
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    const std::string name = entry.path().filename().string();
    if (is_name_of_ours(name) && entry.is_regular_file(failure)) continue;
    return make_error(ErrorCode::kInvalid,
                      "{}: holds {}, which is no part of an atlas; choose another folder", folder, name);
  }
  if (failure) return make_error(ErrorCode::kIo, "{}: {}", folder, failure.message());
  const IndexKind kind = identify_index(folder).kind;
  if (kind == IndexKind::kForeign || (kind == IndexKind::kUnknown && chunks_in(folder).empty())) {
    return make_error(ErrorCode::kInvalid, "{}: is not an atlas of mmlins; choose another folder",
                      index_path(folder));
  }
  return {};
}

/// The index first: none must refer to chunks that are gone.
Status remove_old(const std::string& folder) {
  std::error_code failure;
  for (const char* suffix : {"", "-wal", "-shm", "-journal", ".part", ".part-journal"}) {
    if (!failure) fs::remove(index_path(folder) + suffix, failure);
  }
  for (const int chunk : chunks_in(folder)) {
    if (!failure) fs::remove(chunk_path(folder, chunk), failure);
  }
  if (failure)
    return make_error(ErrorCode::kIo, "{}: the old atlas cannot be removed: {}", folder, failure.message());
  return {};
}

/// Under another name until it is whole.
Status make_index(const std::string& folder) {
  const std::string part = index_path(folder) + ".part";
  {
    auto database = Database::open(part, OpenMode::kCreate);
    if (!database) return database.error();
    if (const Status status = (*database)->execute("BEGIN;" + schema_sql() + "COMMIT;"); !status)
      return status;
  }
  std::error_code failure;
  fs::rename(part, index_path(folder), failure);
  if (failure) return make_error(ErrorCode::kIo, "{}: {}", index_path(folder), failure.message());
  return {};
}

Status check_identity(const std::string& folder) {
  const IndexIdentity identity = identify_index(folder);
  const std::string path = index_path(folder);
  const bool has_chunks = !chunks_in(folder).empty();
  std::error_code failure;
  switch (identity.kind) {
    case IndexKind::kOurs:
      return {};
    case IndexKind::kNewer:
      return make_error(ErrorCode::kUnsupported,
                        "{}: has format {}, this program reads up to {}; use a newer mmlins", path,
                        identity.version, kFormatVersion);
    case IndexKind::kForeign:
      return make_error(ErrorCode::kUnsupported,
                        "{}: belongs to another program; give the folder of an mmlins run", path);
    case IndexKind::kMissing:
      if (!has_chunks)
        return make_error(ErrorCode::kNotFound, "{}: {}; give the folder of a run that has an atlas", folder,
                          fs::is_directory(folder, failure) ? "there is no atlas in it" : "no such folder");
      return make_error(ErrorCode::kInvalid, "{}: is missing; mmlins maps shows and exports what is left",
                        path);
    default:
      if (!has_chunks)
        return make_error(ErrorCode::kUnsupported, "{}: is not an atlas of mmlins, or destroyed", path);
      return make_error(ErrorCode::kInvalid, "{}: is damaged; mmlins maps shows and exports what is left",
                        path);
  }
}

/// Structure only: flipped bits in poses are found by their checksums when they are read.
Status check_structure(Database& database) {
  Statement statement = database.prepare("PRAGMA quick_check(1)");
  const bool has_row = statement.next();
  if (!has_row && !statement.status()) return statement.status();
  const std::string verdict = has_row ? statement.text(0) : "no answer";
  if (verdict == "ok") return {};
  return make_error(ErrorCode::kInvalid, "{}: is damaged ({}); mmlins maps shows and exports what is left",
                    database.path(), verdict.substr(0, verdict.find('\n')));
}

/// Without the rights to write, or on a medium that cannot be written, the log cannot be replayed.
Result<std::unique_ptr<Database>> open_for_reading(const std::string& path) {
  auto database = Database::open(path, OpenMode::kRead);
  if (database.ok() && (*database)->execute("SELECT count(*) FROM sqlite_master").ok()) return database;
  std::error_code failure;
  const bool has_log = fs::exists(path + "-wal", failure) && fs::file_size(path + "-wal", failure) > 0;
  if (has_log) return Database::open(path, OpenMode::kRead);
  return Database::open(path, OpenMode::kUntouched);
}

}  // namespace

Atlas::Atlas(std::string folder, std::unique_ptr<Database> database, const AtlasOptions& options)
    : folder_(std::move(folder)), options_(options), database_(std::move(database)) {}
Atlas::Atlas(Atlas&& other) noexcept = default;

Atlas::~Atlas() {
  if (!database_) return;
  if (const Status status = commit(); !status) log::warning("{}", status.error().message);
}

Status Atlas::become_writer() {
  auto lock = lock_for_writing(folder_);
  if (!lock) return lock.error();
  lock_ = std::make_unique<FileHandle>(std::move(lock).value());
  // A commit is safe against a crash of the process at once, against a power failure from the next checkpoint
  // on.
  return database_->execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL");
}

Result<Atlas> Atlas::create(const std::string& folder, const AtlasOptions& options) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) return make_error(ErrorCode::kIo, "{}: cannot be made: {}", folder, failure.message());
  if (const Status status = check_replaceable(folder); !status) return status.error();
  {
    auto lock = lock_for_writing(folder);
    if (!lock) return lock.error();
    if (const Status status = remove_old(folder); !status) return status.error();
    if (const Status status = make_index(folder); !status) return status.error();
  }
  return open(folder, Access::kWrite, options);
}

Status Atlas::move(const std::string& folder, const std::string& to) {
  std::error_code failure;
  if (!fs::exists(folder, failure)) return {};
  if (const Status status = check_replaceable(folder); !status) return status;
  auto lock = lock_for_writing(folder);
  if (!lock) return lock.error();
  fs::rename(folder, to, failure);
  if (failure) return make_error(ErrorCode::kIo, "{}: cannot be moved to {}: {}", folder, to, failure.message());
  return {};
}

Result<Atlas> Atlas::open(const std::string& folder, Access access, const AtlasOptions& options) {
  if (const Status status = check_identity(folder); !status) return status.error();
  const std::string path = index_path(folder);
  auto database = access == Access::kWrite ? Database::open(path, OpenMode::kWrite) : open_for_reading(path);
  if (!database) return database.error();
  if (const Status status = check_structure(**database); !status) return status.error();
  Atlas atlas(folder, std::move(database).value(), options);
  if (access == Access::kRead) return atlas;
  if (const Status status = atlas.become_writer(); !status) return status.error();
  // Nobody is writing: a map that is still active was left so by a process that was killed.
  const Status status = atlas.database_->execute(
      "UPDATE map SET state = 'sleeping', why_ended = CASE why_ended WHEN '' THEN 'the program ended' ELSE "
      "why_ended "
      "END, last_ns = max(last_ns, coalesce((SELECT max(time_ns) FROM keyframe WHERE map = map.id), "
      "last_ns)) "
      "WHERE state = 'active'");
  if (!status) return status.error();
  return atlas;
}

Result<Atlas> Atlas::reader(const std::string& folder) {
  // By SQLite alone: if any other code of this process closed the file, the locks of the writer would go.
  auto database = open_for_reading(index_path(folder));
  if (!database) return database.error();
  return Atlas(folder, std::move(database).value(), {});
}

std::string find_atlas(const std::string& folder) {
  std::error_code failure;
  const std::string inner = folder + "/atlas";
  return fs::is_directory(inner, failure) ? inner : folder;
}

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
#include "mmlins/atlas/database.hpp"

#include <sqlite3.h>

#include <array>

namespace mmlins::atlas {
namespace {

constexpr int kBusyMilliseconds = 5000;  ///< a reader may hold the index for a moment

Error describe_failure(const std::string& path, int code, const char* message) {
  switch (code & 0xff) {
    case SQLITE_FULL:
      return make_error(ErrorCode::kIo, "{}: cannot be written: the disk is full; free some space", path);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return make_error(ErrorCode::kInvalid,
                        "{}: is damaged ({}); mmlins maps shows and exports what is left", path, message);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return make_error(ErrorCode::kIo, "{}: is in use by another program; wait until that has ended", path);
    case SQLITE_READONLY:
      return make_error(ErrorCode::kIo, "{}: cannot be written ({}); check the rights of its folder", path,
                        message);
    default:
      return make_error(ErrorCode::kIo, "{}: {}", path, message);
  }
}

/// A path as URI, for options that only a URI can carry.
std::string untouched_uri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

int open_flags(OpenMode mode) {
  switch (mode) {
    case OpenMode::kCreate:
    case OpenMode::kMemory:
      return SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    case OpenMode::kUntouched:
      return SQLITE_OPEN_READONLY | SQLITE_OPEN_URI;
    default:
      return SQLITE_OPEN_READWRITE;  // which falls back to reading if writing is not allowed
  }
}

}  // namespace

Statement::Statement(sqlite3* connection, std::string_view sql, const std::string& file)
    : connection_(connection), file_(&file) {
  sqlite3_stmt* statement = nullptr;
  check(sqlite3_prepare_v2(connection, sql.data(), static_cast<int>(sql.size()), &statement, nullptr));
  statement_.reset(statement);
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Error Statement::describe(int code) const {
  return describe_failure(*file_, code, sqlite3_errmsg(connection_));
}

void Statement::check(int code) {
  if (code != SQLITE_OK && !error_) error_ = describe(code);
}

Statement& Statement::bind(std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), ++num_bound_, value));
  return *this;
}

Statement& Statement::bind(double value) {
  check(sqlite3_bind_double(statement_.get(), ++num_bound_, value));
  return *this;
}

Statement& Statement::bind(std::string_view value) {
  const char* const text = value.data() == nullptr ? "" : value.data();
  check(sqlite3_bind_text(statement_.get(), ++num_bound_, text, static_cast<int>(value.size()),
                          SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::bind(Bytes value) {
  const Bytes bytes = sealed(std::move(value));
  const auto size = static_cast<int>(bytes.size());
  check(sqlite3_bind_blob(statement_.get(), ++num_bound_, bytes.data(), size, SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::bind_row(const Statement& other) {
  for (int column = 0; column < other.num_columns(); ++column) {
    check(sqlite3_bind_value(statement_.get(), ++num_bound_,
                             sqlite3_column_value(other.statement_.get(), column)));
  }
  return *this;
}

bool Statement::next() {
  if (error_) return false;
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) check(code);
  return false;
}

Status Statement::run() {
  while (next()) {
  }
  const Status result = status();
  sqlite3_reset(statement_.get());
  num_bound_ = 0;
  error_.reset();
  return result;
}

int Statement::num_columns() const { return sqlite3_column_count(statement_.get()); }
std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
double Statement::real(int column) const { return sqlite3_column_double(statement_.get(), column); }
bool Statement::is_blob(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_BLOB;
}

std::string Statement::text(int column) const {
  const auto* const begin = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  if (begin == nullptr) return {};
  return {begin, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::optional<ByteView> Statement::blob(int column) const {
  const auto* const begin = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  if (begin == nullptr) return std::nullopt;
  return unsealed({begin, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))});
}

Result<std::unique_ptr<Database>> Database::open(const std::string& path, OpenMode mode) {
  std::unique_ptr<Database> database(new Database(path));
  std::string name = mode == OpenMode::kUntouched ? untouched_uri(path) : path;
  if (mode == OpenMode::kMemory) name = ":memory:";
  const int flags = open_flags(mode) | SQLITE_OPEN_NOMUTEX;
  const int code = sqlite3_open_v2(name.c_str(), &database->connection_, flags, nullptr);
  if (code != SQLITE_OK) return describe_failure(path, code, sqlite3_errstr(code));
  sqlite3_busy_timeout(database->connection_, kBusyMilliseconds);
  if (mode == OpenMode::kRead) {
    if (const Status status = database->execute("PRAGMA query_only = ON"); !status) return status.error();
  }
  return database;
}

Database::~Database() { sqlite3_close_v2(connection_); }

Status Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(connection_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code == SQLITE_OK) return {};
  return describe_failure(path_, code, sqlite3_errmsg(connection_));
}

bool Database::is_in_transaction() const { return sqlite3_get_autocommit(connection_) == 0; }
std::int64_t Database::last_id() const { return sqlite3_last_insert_rowid(connection_); }

Transaction::~Transaction() {
  // Some failures have ended it already.
  if (database_.is_in_transaction()) (void)database_.execute("ROLLBACK");
}

}  // namespace mmlins::atlas

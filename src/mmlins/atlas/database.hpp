// SPDX-License-Identifier: MIT
#pragma once
// SQLite in the manner of this project: no exceptions, errors in one line that names the file. Internal to
// atlas/.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "mmlins/atlas/bytes.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/base/time.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace mmlins::atlas {

/// A prepared statement. Errors stay in it: bind, run or step through all, then ask status() once.
class Statement {
 public:
  Statement(sqlite3* connection, std::string_view sql, const std::string& file);

  /// The next parameter, in the order of the question marks.
  Statement& bind(std::int64_t value);
  Statement& bind(int value) { return bind(std::int64_t{value}); }
  Statement& bind(bool value) { return bind(std::int64_t{value}); }
  Statement& bind(Time value) { return bind(to_ns(value)); }
  Statement& bind(double value);
  Statement& bind(std::string_view value);
  /// Stored with its checksum.
  Statement& bind(Bytes value);
  /// The next parameters as they are in a row of another statement.
  Statement& bind_row(const Statement& other);

  /// Steps to the next row. @return false at the end or after an error
  bool next();
  /// Executes a statement that gives no rows and makes it ready for the next parameters.
  Status run();
  [[nodiscard]] Status status() const { return error_ ? Status(*error_) : Status(); }

  [[nodiscard]] int num_columns() const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] int int32(int column) const { return static_cast<int>(integer(column)); }
  [[nodiscard]] Time time(int column) const { return time_from_ns(integer(column)); }
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] bool is_blob(int column) const;
  /// Without its checksum; nothing if it is damaged. Valid until the next step.
  [[nodiscard]] std::optional<ByteView> blob(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  void check(int code);
  [[nodiscard]] Error describe(int code) const;

  sqlite3* connection_;
  const std::string* file_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  std::optional<Error> error_;
  int num_bound_ = 0;
};

enum class OpenMode {
  kCreate,     ///< makes the file
  kWrite,      ///< the file must exist
  kRead,       ///< as kWrite, but every change is refused
  kUntouched,  ///< neither locks nor a look at the write-ahead log: for damaged files
  kMemory,     ///< no file; the path only serves messages
};

class Database {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Database>> open(const std::string& path, OpenMode mode);
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  [[nodiscard]] Statement prepare(std::string_view sql) { return {connection_, sql, path_}; }
  /// One or more statements without parameters.
  [[nodiscard]] Status execute(const std::string& sql);
  [[nodiscard]] bool is_in_transaction() const;
  [[nodiscard]] std::int64_t last_id() const;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  explicit Database(std::string path) : path_(std::move(path)) {}

  std::string path_;
  sqlite3* connection_ = nullptr;
};

/// All or nothing: what is not committed is undone.
class Transaction {
 public:
  explicit Transaction(Database& database) : database_(database) {}
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  ~Transaction();

  [[nodiscard]] Status begin() { return database_.execute("BEGIN IMMEDIATE"); }
  [[nodiscard]] Status commit() { return database_.execute("COMMIT"); }

 private:
  Database& database_;
};

}  // namespace mmlins::atlas

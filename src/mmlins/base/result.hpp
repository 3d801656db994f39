// SPDX-License-Identifier: MIT
#pragma once
// Result<T>: a value, or one line that tells a user what went wrong, where, and what to do about it.
// For everything that comes from outside (files, recordings, options). Expected outcomes of algorithms
// are status enums in result structs; programmer errors are checks.

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "mmlins/base/check.hpp"

namespace mmlins {

enum class ErrorCode { kNotFound, kInvalid, kUnsupported, kIo, kInterrupted };

/// What went wrong: one line, naming the file, topic, field or key, and what to do.
struct Error {
  ErrorCode code = ErrorCode::kInvalid;
  std::string message;
};

/// Builds an Error with a formatted message.
template <typename... Args>
[[nodiscard]] Error make_error(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return Error{code, fmt::format(format, std::forward<Args>(args)...)};
}

/// Either a value or an Error. Reading the one that is not there is a programmer error.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }

  T& value() & { return (MMLINS_CHECK(ok()), std::get<T>(content_)); }
  const T& value() const& { return (MMLINS_CHECK(ok()), std::get<T>(content_)); }
  T&& value() && { return (MMLINS_CHECK(ok()), std::get<T>(std::move(content_))); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const { return (MMLINS_CHECK(!ok()), std::get<Error>(content_)); }

 private:
  std::variant<T, Error> content_;
};

/// A Result that carries no value.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return (MMLINS_CHECK(!ok()), *error_); }

 private:
  std::optional<Error> error_;
};

using Status = Result<void>;

}  // namespace mmlins

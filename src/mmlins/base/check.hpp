// SPDX-License-Identifier: MIT
#pragma once
// Checks for programmer errors. Nothing that came from a sensor, a file or a user is ever CHECKed.

#include <cstdio>
#include <cstdlib>

namespace mmlins::detail {
[[noreturn]] inline void check_failed(const char* file, int line, const char* condition) {
  std::fprintf(stderr, "%s:%d: check failed: %s\n", file, line, condition);
  std::abort();
}
}  // namespace mmlins::detail

/// Aborts with file, line and condition if the condition does not hold. An expression.
#define MMLINS_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::mmlins::detail::check_failed(__FILE__, __LINE__, #condition))

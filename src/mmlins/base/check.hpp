// SPDX-License-Identifier: MIT
#pragma once
// Checks for programmer errors. Nothing that came from a sensor, a file or a user is ever CHECKed.

#include <cstdio>
#include <cstdlib>

#define MMLINS_CHECK(condition)                                                                       \
  do {                                                                                                \
    if (!(condition)) {                                                                               \
      std::fprintf(stderr, "%s:%d: check failed: %s\n", __FILE__, __LINE__, #condition);              \
      std::abort();                                                                                   \
    }                                                                                                 \
  } while (false)

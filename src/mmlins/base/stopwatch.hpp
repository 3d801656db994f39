// SPDX-License-Identifier: MIT
#pragma once
// How long a piece of work took. The only use of a clock in the library; results never depend on it.

#include <chrono>

namespace mmlins {

class Stopwatch {
 public:
  /// Milliseconds since construction or the last call.
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace mmlins

// SPDX-License-Identifier: MIT
#include "mmlins/base/log.hpp"

namespace mmlins::log {
namespace {
Sink& installed_sink() {
  static Sink sink;
  return sink;
}
}  // namespace

void set_sink(Sink sink) { installed_sink() = std::move(sink); }

void write(Level level, const std::string& message) {
  if (const Sink& sink = installed_sink()) sink(level, message);
}

}  // namespace mmlins::log

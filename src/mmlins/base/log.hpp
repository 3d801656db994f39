// SPDX-License-Identifier: MIT
#pragma once
// State changes and rejected data, in words. Numbers belong into result structs, not here.
// The library writes nowhere by itself: a program installs the sink.

#include <fmt/format.h>

#include <functional>
#include <string>
#include <utility>

namespace mmlins::log {

enum class Level { kInfo, kWarning };

using Sink = std::function<void(Level, const std::string&)>;

/// Where messages go from now on; without a sink they are dropped. Call before any thread is started.
void set_sink(Sink sink);
void write(Level level, const std::string& message);

template <typename... Args>
void info(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kInfo, fmt::format(format, std::forward<Args>(args)...));
}

template <typename... Args>
void warning(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kWarning, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace mmlins::log

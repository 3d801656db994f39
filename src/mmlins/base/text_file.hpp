// SPDX-License-Identifier: MIT
#pragma once
#include <string>

#include "mmlins/base/result.hpp"

namespace mmlins {

/// @param reason  an errno
[[nodiscard]] Error cannot_write(const std::string& path, int reason);

/// Replaces the file at once: written under a temporary name in the same folder, then renamed.
[[nodiscard]] Status write_text_file(const std::string& path, const std::string& text);

/// The whole file as text.
[[nodiscard]] Result<std::string> read_text_file(const std::string& path);

}  // namespace mmlins

// SPDX-License-Identifier: MIT
#pragma once
// Pictures as PNG, and bytes as text that can stand inside an HTML page. The only folder that sees libpng.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mmlins/base/result.hpp"

namespace mmlins::report {

/// A brightness and an opacity per pixel, row by row from the top.
struct GrayAlphaImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  ///< gray, alpha, gray, alpha, ...; 2 * width * height
};

/// The same bytes for the same image. Error: an image without pixels, or what libpng says.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_png(const GrayAlphaImage& image);

/// RFC 4648, with padding.
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace mmlins::report

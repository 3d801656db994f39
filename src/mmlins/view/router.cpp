// SPDX-License-Identifier: MIT
#include "mmlins/view/router.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <optional>

namespace mmlins::view {
namespace {

constexpr std::string_view kTiles = "/api/tiles/";

/// FIRST-LAST/LEVEL
std::optional<std::array<int, 3>> parse_tile(std::string_view text) {
  std::array<int, 3> numbers{};
  constexpr std::string_view kAfter = "-/";
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), numbers[i]);
    if (failure != std::errc() || numbers[i] < 0) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (i == kAfter.size()) break;
    if (text.empty() || text.front() != kAfter[i]) return std::nullopt;
    text.remove_prefix(1);
  }
  return text.empty() ? std::optional(numbers) : std::nullopt;
}

}  // namespace

bool is_own_host(std::string_view host) {
  if (host.empty()) return false;
  const std::size_t colon = host.rfind(':');
  const bool has_port = colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos;
  const std::string_view name = has_port ? host.substr(0, colon) : host;
  return name == "localhost" || name == "[::1]" ||
         (name.starts_with("127.") && name.find_first_not_of("0123456789.") == std::string_view::npos);
}

bool is_same_origin(std::string_view origin, std::string_view host) {
  return origin.empty() || (origin.starts_with("http://") && origin.substr(7) == host);
}

Response answer(std::string_view target, Content& content) {
  const std::string_view path = target.substr(0, target.find('?'));
  if (path == "/" || path == "/index.html") return {200, "text/html; charset=utf-8", std::string(page())};
  if (path == "/api/scene") return {200, "application/json", content.scene()};
  if (path.starts_with(kTiles)) {
    const auto tile = parse_tile(path.substr(kTiles.size()));
    if (tile) return content.tile((*tile)[0], (*tile)[1], (*tile)[2]);
    return {400, Response().type, "tiles are asked for as /api/tiles/FIRST-LAST/LEVEL\n"};
  }
  return {404, Response().type, fmt::format("there is no {}\n", path.substr(0, 200))};
}

}  // namespace mmlins::view

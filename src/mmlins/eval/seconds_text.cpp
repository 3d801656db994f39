// SPDX-License-Identifier: MIT
// Seconds as decimal text, to and from integer nanoseconds.
#include <algorithm>
#include <charconv>
#include <limits>

#include "mmlins/eval/trajectory_file.hpp"

namespace mmlins::eval {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::size_t kLongestNumber = 64;  ///< characters; no stamp is longer
constexpr std::size_t kMostDigits = 18;     ///< what an int64 holds whatever the digits

/// Digits and the place of the decimal point: value = 0.DIGITS * 10^point.
struct Decimal {
  bool negative = false;
  std::string digits;
  int point = 0;
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::optional<Decimal> parse_decimal(std::string_view text) {
  Decimal decimal;
  if (text.size() > kLongestNumber || text.empty()) return std::nullopt;
  decimal.negative = text[0] == '-';
  if (text[0] == '-' || text[0] == '+') text.remove_prefix(1);
  bool after_point = false;
  std::size_t i = 0;
  for (; i < text.size() && (is_digit(text[i]) || (text[i] == '.' && !after_point)); ++i) {
    if (text[i] == '.') {
      after_point = true;
    } else {
      decimal.digits += text[i];
      if (!after_point) ++decimal.point;
    }
  }
  if (decimal.digits.empty()) return std::nullopt;
  if (i == text.size()) return decimal;
  if (text[i] != 'e' && text[i] != 'E') return std::nullopt;
  text.remove_prefix(i + 1);
  if (text.size() > 1 && text[0] == '+' && is_digit(text[1])) text.remove_prefix(1);
  int exponent = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), exponent);
  if (error != std::errc{} || end != text.data() + text.size() || std::abs(exponent) > 100)
    return std::nullopt;
  decimal.point += exponent;
  return decimal;
}

}  // namespace

std::optional<std::int64_t> parse_seconds_as_ns(std::string_view text) {
  std::optional<Decimal> decimal = parse_decimal(text);
  if (!decimal) return std::nullopt;
  const int num_whole = decimal->point + 9;  // digits before the point, in nanoseconds
  if (num_whole < 0) return 0;
  decimal->digits.resize(std::max(decimal->digits.size(), static_cast<std::size_t>(num_whole) + 1), '0');
  const std::size_t first =
      std::min(decimal->digits.find_first_not_of('0'), static_cast<std::size_t>(num_whole));
  if (static_cast<std::size_t>(num_whole) - first > kMostDigits + 1) return std::nullopt;
  std::int64_t ns = 0;
  const char* begin = decimal->digits.data() + first;
  const char* end = decimal->digits.data() + num_whole;
  if (begin != end && std::from_chars(begin, end, ns).ec != std::errc{}) return std::nullopt;
  if (ns == std::numeric_limits<std::int64_t>::max()) return std::nullopt;
  if (decimal->digits[static_cast<std::size_t>(num_whole)] >= '5') ++ns;
  return decimal->negative ? -ns : ns;
}

std::string seconds_text(Time time) {
  const std::int64_t ns = to_ns(time);
  const auto magnitude = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  return fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", magnitude / kNanosecondsPerSecond,
                     magnitude % kNanosecondsPerSecond);
}

}  // namespace mmlins::eval

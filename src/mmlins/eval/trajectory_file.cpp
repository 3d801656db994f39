// SPDX-License-Identifier: MIT
#include "mmlins/eval/trajectory_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "mmlins/base/text_file.hpp"

namespace mmlins::eval {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr double kQuaternionTolerance = 0.1;  ///< a quaternion whose length is farther from 1 is a mistake

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

std::optional<double> parse_finite(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double number = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  const bool whole = error == std::errc{} && end == word.data() + word.size();
  return whole && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// One row. The error is without its place.
Result<math::StampedPose> parse_row(const std::vector<std::string_view>& words) {
  if (words.size() != 8) {
    return make_error(ErrorCode::kInvalid, "{} columns; a pose is \"time x y z qx qy qz qw\"", words.size());
  }
  const std::optional<std::int64_t> ns = parse_seconds_as_ns(words[0]);
  if (!ns) return make_error(ErrorCode::kInvalid, "\"{}\" is not a time in seconds", words[0]);
  std::array<double, 7> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<double> number = parse_finite(words[i + 1]);
    if (!number) return make_error(ErrorCode::kInvalid, "\"{}\" is not a finite number", words[i + 1]);
    numbers[i] = *number;
  }
  const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (!(std::abs(q.norm() - 1.0) < kQuaternionTolerance)) {
    return make_error(ErrorCode::kInvalid,
                      "quaternion of length {:.3g}; the last four columns are qx qy qz qw", q.norm());
  }
  const math::Vector3d position(numbers[0], numbers[1], numbers[2]);
  return math::StampedPose{time_from_ns(*ns), {q.normalized().toRotationMatrix(), position}};
}

TumFile put_in_order(math::Trajectory poses) {
  TumFile file;
  for (std::size_t i = 1; i < poses.size(); ++i)
    file.num_out_of_order += poses[i].time < poses[i - 1].time ? 1 : 0;
  std::stable_sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  const auto end =
      std::unique(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.time == b.time; });
  file.num_duplicates = static_cast<int>(poses.end() - end);
  poses.erase(end, poses.end());
  file.poses = std::move(poses);
  return file;
}

}  // namespace

Result<TumFile> parse_tum(std::string_view text, const std::string& source) {
  math::Trajectory poses;
  for (int line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::vector<std::string_view> words = split_words(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty() || words[0][0] == '#') continue;
    const Result<math::StampedPose> pose = parse_row(words);
    if (!pose) return make_error(ErrorCode::kInvalid, "{}:{}: {}", source, line_number, pose.error().message);
    poses.push_back(*pose);
  }
  if (poses.empty()) {
    return make_error(ErrorCode::kInvalid,
                      "{}: holds no pose; give a file of \"time x y z qx qy qz qw\" lines", source);
  }
  return put_in_order(std::move(poses));
}

Result<TumFile> read_tum(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_tum(*text, path);
}

std::string tum_line(const math::StampedPose& stamped) {
  const math::Vector3d& p = stamped.pose.t;
  const Eigen::Quaterniond q = stamped.pose.quaternion();
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} {:.12f}", seconds_text(stamped.time),
                     p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

Status write_tum(const std::string& path, const math::Trajectory& trajectory) {
  std::string text;
  for (const math::StampedPose& stamped : trajectory) text += tum_line(stamped) + '\n';
  return write_text_file(path, text);
}

}  // namespace mmlins::eval

// SPDX-License-Identifier: MIT
#include "mmlins/config/yaml_value.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "mmlins/config/field_index.hpp"

namespace mmlins::config {
namespace {

Error refuse(const std::string& what) { return Error{ErrorCode::kInvalid, what}; }

// yaml-cpp marks plain scalars with the tag "?" and quoted ones with "!".
bool is_plain_scalar(const YAML::Node& node) { return node.IsScalar() && node.Tag() != "!"; }

/// How a value is called in a message.
std::string shown(const YAML::Node& node) {
  if (node.IsNull()) return "has no value";
  if (node.IsSequence()) return fmt::format("is a list of {}", node.size());
  if (node.IsMap()) return "is a group";
  return is_plain_scalar(node) ? fmt::format("is {}", node.Scalar())
                               : fmt::format("is the text \"{}\"", node.Scalar());
}

/// Reads the whole text as a number. std::from_chars does not depend on the locale and is exact.
template <typename Number>
std::errc read_number(std::string_view text, Number& number) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return error;
  return end == text.data() + text.size() ? std::errc{} : std::errc::invalid_argument;
}

bool is_yaml_non_finite(const std::string& text) {
  static constexpr std::string_view kWords[] = {".inf", "+.inf", "-.inf", ".nan"};
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::find(std::begin(kWords), std::end(kWords), lower) != std::end(kWords);
}

Status check_range(const Field& field, double number) {
  if (number >= field.range.min && number <= field.range.max) return {};
  return refuse(fmt::format("is {}, out of range", number));
}

Result<double> check_number(const Field& field, const YAML::Node& node) {
  double number = 0.0;
  if (!is_plain_scalar(node)) return refuse(shown(node));
  if (is_yaml_non_finite(node.Scalar())) return refuse(shown(node) + ", not finite");
  const std::errc error = read_number(node.Scalar(), number);
  if (error == std::errc::result_out_of_range) return refuse(shown(node) + ", more than a number can hold");
  if (error != std::errc{}) return refuse(shown(node));
  if (!std::isfinite(number)) return refuse(shown(node) + ", not finite");
  if (const Status status = check_range(field, number); !status) return status.error();
  return number;
}

struct Checker {
  const Field& field;
  const YAML::Node& node;

  Result<Assignment> operator()(double* target) const {
    const Result<double> number = check_number(field, node);
    if (!number) return number.error();
    return Assignment([target, value = *number] { *target = value; });
  }

  Result<Assignment> operator()(int* target) const {
    int number = 0;
    if (!is_plain_scalar(node)) return refuse(shown(node));
    const std::errc error = read_number(node.Scalar(), number);
    if (error == std::errc::result_out_of_range) return refuse(shown(node) + ", out of range");
    if (error != std::errc{}) return refuse(shown(node));
    if (const Status status = check_range(field, number); !status) return status.error();
    return Assignment([target, number] { *target = number; });
  }

  Result<Assignment> operator()(bool* target) const {
    const bool value = is_plain_scalar(node) && node.Scalar() == "true";
    if (!value && !(is_plain_scalar(node) && node.Scalar() == "false")) return refuse(shown(node));
    return Assignment([target, value] { *target = value; });
  }

  Result<Assignment> operator()(std::string* target) const {
    if (node.IsNull()) return Assignment([target] { target->clear(); });
    if (!node.IsScalar()) return refuse(shown(node));
    return Assignment([target, text = node.Scalar()] { *target = text; });
  }

  Result<Assignment> operator()(const NumbersAccess& target) const {
    if (!node.IsSequence() || node.size() != static_cast<std::size_t>(target.size))
      return refuse(shown(node));
    std::vector<double> numbers;
    for (std::size_t i = 0; i < node.size(); ++i) {
      const Result<double> number = check_number(field, node[i]);
      if (!number) return refuse(fmt::format("[{}] {}", i, number.error().message));
      numbers.push_back(*number);
    }
    return Assignment([target, numbers] { std::copy(numbers.begin(), numbers.end(), target.data); });
  }

  Result<Assignment> operator()(const EnumAccess& target) const {
    if (!node.IsScalar()) return refuse(shown(node));
    const auto word = std::find(target.words.begin(), target.words.end(), node.Scalar());
    if (word == target.words.end()) {
      const std::string nearest = nearest_word(target.words, node.Scalar());
      return refuse(nearest.empty() ? shown(node)
                                    : fmt::format("{} (did you mean {}?)", shown(node), nearest));
    }
    return Assignment(
        [&target, index = static_cast<int>(word - target.words.begin())] { target.set(index); });
  }

  Result<Assignment> operator()(const Fields&) const { return refuse("is a group of settings"); }
  Result<Assignment> operator()(const GroupsAccess&) const { return refuse("is a list of groups"); }
};

}  // namespace

Result<Assignment> check_value(const Field& field, const YAML::Node& node) {
  return std::visit(Checker{field, node}, field.value);
}

}  // namespace mmlins::config

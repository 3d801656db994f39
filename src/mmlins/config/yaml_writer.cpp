// SPDX-License-Identifier: MIT
// Writing: plain text by hand, since the comments and the exact digits matter.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string_view>
#include <vector>

#include "mmlins/config/field_index.hpp"
#include "mmlins/config/yaml_config.hpp"

namespace mmlins::config {
namespace {

constexpr std::size_t kLineWidth = 100;

bool is_plain_word(const std::string& text) {
  // Words that some YAML reader takes for something other than text.
  static constexpr std::string_view kReserved[] = {"true", "false", "null", "yes", "no", "on",
                                                   "off",  "y",     "n",    "nan", "inf"};
  if (text.empty() || !(std::isalpha(static_cast<unsigned char>(text[0])) || text[0] == '/')) return false;
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  if (std::find(std::begin(kReserved), std::end(kReserved), lower) != std::end(kReserved)) return false;
  return std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '/' || c == '-' || c == '.' || c == '^';
  });
}

std::string text_scalar(const std::string& text) {
  if (is_plain_word(text)) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += fmt::format("\\{}", c);
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

/// The value as YAML. "{}" of a double is the shortest text that reads back to the same bits.
struct ValueText {
  std::string operator()(const double* value) const { return fmt::format("{}", *value); }
  std::string operator()(const int* value) const { return fmt::format("{}", *value); }
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::string* value) const { return text_scalar(*value); }
  std::string operator()(const NumbersAccess& numbers) const {
    return fmt::format("[{}]", fmt::join(numbers.data, numbers.data + numbers.size, ", "));
  }
  std::string operator()(const EnumAccess& access) const {
    return text_scalar(access.words.at(static_cast<std::size_t>(access.get())));
  }
  std::string operator()(const Fields&) const { return ""; }
  /// One line for each element, which is short.
  std::string operator()(const GroupsAccess& list) const {
    const std::vector<Fields> items = list.items();
    if (items.empty()) return "[]";
    std::string text;
    for (const Fields& item : items) text += fmt::format("\n  - {{{}}}", on_one_line(item));
    return text;
  }
  static std::string on_one_line(const Fields& fields) {
    std::string text;
    for (const Field& field : fields) {
      text += fmt::format("{}{}: ", text.empty() ? "" : ", ", field.name);
      const auto* members = std::get_if<Fields>(&field.value);
      const auto* list = std::get_if<GroupsAccess>(&field.value);
      if (members != nullptr) text += fmt::format("{{{}}}", on_one_line(*members));
      if (list != nullptr) text += list_on_one_line(*list);
      if (members == nullptr && list == nullptr) text += std::visit(ValueText{}, field.value);
    }
    return text;
  }
  static std::string list_on_one_line(const GroupsAccess& list) {
    std::string text;
    for (const Fields& item : list.items()) {
      text += fmt::format("{}{{{}}}", text.empty() ? "" : ", ", on_one_line(item));
    }
    return fmt::format("[{}]", text);
  }
};

/// "meaning [0.1 to 5 m]"; the type is not named where the value shows it.
std::string comment_text(const Field& field) {
  const bool is_enum = std::holds_alternative<EnumAccess>(field.value);
  const std::string limits = is_enum ? accepted_values(field) : range_text(field);
  return limits.empty() ? field.meaning : fmt::format("{} [{}]", field.meaning, limits);
}

/// The words of a comment; a range in brackets is one word.
std::vector<std::string> comment_words(const std::string& text) {
  const std::size_t bracket = std::min(text.rfind('['), text.size());
  std::istringstream stream(text.substr(0, bracket));
  std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
  if (bracket < text.size()) words.push_back(text.substr(bracket));
  return words;
}

std::string wrapped_comment(const std::string& text, const std::string& indent) {
  std::string lines;
  std::string line = indent + "#";
  for (const std::string& word : comment_words(text)) {
    if (line.size() + 1 + word.size() > kLineWidth && line.size() > indent.size() + 1) {
      lines += line + "\n";
      line = indent + "#";
    }
    line += " " + word;
  }
  return lines + line + "\n";
}

std::string fields_text(const Fields& fields, bool with_comments, const std::string& indent) {
  std::string text;
  for (const Field& field : fields) {
    const auto* members = std::get_if<Fields>(&field.value);
    if (with_comments && members != nullptr && !text.empty()) text += "\n";
    if (with_comments) text += wrapped_comment(comment_text(field), indent);
    if (members != nullptr) {
      text +=
          fmt::format("{}{}:\n{}", indent, field.name, fields_text(*members, with_comments, indent + "  "));
    } else {
      const std::string value = std::visit(ValueText{}, field.value);
      text += fmt::format("{}{}:{}{}\n", indent, field.name, value.starts_with('\n') ? "" : " ", value);
    }
  }
  return text;
}

}  // namespace

std::string to_yaml(const Fields& fields, bool with_comments) {
  return fields_text(fields, with_comments, "");
}

}  // namespace mmlins::config

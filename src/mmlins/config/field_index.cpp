// SPDX-License-Identifier: MIT
#include "mmlins/config/field_index.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mmlins::config {
namespace {

void append_fields(const Fields& fields, const std::string& prefix, std::vector<NamedField>& index) {
  for (const Field& field : fields) {
    const std::string name = prefix + field.name;
    index.push_back({name, &field});
    if (const auto* members = std::get_if<Fields>(&field.value)) append_fields(*members, name + ".", index);
  }
}

/// Levenshtein distance: insertions, deletions and replacements of single characters.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

/// How many edits still count as a slip of the pen.
std::size_t largest_slip(const std::string& name) { return std::max<std::size_t>(2, name.size() / 3); }

std::string last_part(const std::string& name) { return name.substr(name.rfind('.') + 1); }

struct AcceptedText {
  const Field& field;
  std::string with_range(const std::string& type) const {
    const std::string range = range_text(field);
    return range.empty() ? type : type + ", " + range;
  }
  std::string operator()(double*) const { return with_range("a number"); }
  std::string operator()(int*) const { return with_range("a whole number"); }
  std::string operator()(bool*) const { return "true or false"; }
  std::string operator()(std::string*) const { return "text"; }
  std::string operator()(const NumbersAccess& numbers) const {
    return with_range(fmt::format("a list of {} numbers", numbers.size));
  }
  std::string operator()(const EnumAccess& access) const {
    return fmt::format("{}", fmt::join(access.words, " | "));
  }
  std::string operator()(const Fields&) const { return "a group of \"key: value\" lines"; }
  std::string operator()(const GroupsAccess&) const { return "a list of groups, - {key: value, ...}"; }
};

}  // namespace

std::vector<NamedField> index_fields(const Fields& fields, const std::string& prefix) {
  std::vector<NamedField> index;
  append_fields(fields, prefix, index);
  return index;
}

const Field* find_field(const std::vector<NamedField>& index, const std::string& name) {
  const auto found =
      std::find_if(index.begin(), index.end(), [&](const NamedField& f) { return f.name == name; });
  return found == index.end() ? nullptr : found->field;
}

std::string nearest_name(const std::vector<NamedField>& index, const std::string& name) {
  const std::string last = last_part(name);
  const NamedField* nearest = nullptr;
  std::size_t smallest = 0;
  for (const NamedField& candidate : index) {
    const std::size_t whole = edit_distance(name, candidate.name);
    // The right word in the wrong group: one edit dearer than a slip in the whole name.
    const std::size_t part = edit_distance(last, last_part(candidate.name)) + 1;
    const bool near = whole <= largest_slip(name) || part <= largest_slip(last);
    const std::size_t distance = std::min(whole, part);
    if (near && (nearest == nullptr || distance < smallest)) {
      nearest = &candidate;
      smallest = distance;
    }
  }
  return nearest == nullptr ? "" : nearest->name;
}

std::string nearest_word(const std::vector<std::string>& words, const std::string& word) {
  std::string nearest;
  std::size_t smallest = largest_slip(word) + 1;
  for (const std::string& candidate : words) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < smallest && distance < candidate.size()) {
      nearest = candidate;
      smallest = distance;
    }
  }
  return nearest;
}

std::string accepted_values(const Field& field) { return std::visit(AcceptedText{field}, field.value); }

std::string range_text(const Field& field) {
  const bool has_min = std::isfinite(field.range.min);
  const bool has_max = std::isfinite(field.range.max);
  std::string text;
  if (has_min && has_max) {
    text = fmt::format("{} to {}", field.range.min, field.range.max);
  } else if (has_min) {
    text = fmt::format("at least {}", field.range.min);
  } else if (has_max) {
    text = fmt::format("at most {}", field.range.max);
  }
  if (field.unit.empty()) return text;
  return text.empty() ? "in " + field.unit : text + " " + field.unit;
}

}  // namespace mmlins::config

// SPDX-License-Identifier: MIT
#pragma once
// One list of fields per config struct: name, unit, range and meaning, pointing at the member that
// holds the value. The default is the member's initialiser and stands nowhere else. YAML reading and
// writing, the printed reference and the range check are all made from this list (config/yaml_config.hpp).

#include <array>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace mmlins {

struct Field;
/// All fields of one struct; valid as long as the struct they were taken from stays where it is.
using Fields = std::vector<Field>;

/// Smallest and largest accepted value, both included.
struct FieldRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// An enum as text: the accepted words, and access to the current one by its index.
struct EnumAccess {
  std::vector<std::string> words;
  std::function<int()> get;
  std::function<void(int)> set;
};

/// A list of numbers of fixed length, such as a vector or a quaternion.
struct NumbersAccess {
  double* data = nullptr;
  int size = 0;
};

/// A list that is being read: it replaces the old one only when all of it has been accepted.
class GroupsDraft {
 public:
  virtual ~GroupsDraft() = default;
  /// Adds an element with its defaults. @return its fields, valid as long as the draft
  virtual Fields append() = 0;
  virtual void replace_list() = 0;
};

/// A list of config structs of one kind, of any length.
struct GroupsAccess {
  std::function<std::vector<Fields>()> items;  ///< the fields of each element as it is now
  std::function<std::shared_ptr<GroupsDraft>()> draft;
};

using FieldValue = std::variant<double*, int*, bool*, std::string*, NumbersAccess, EnumAccess,
                                Fields /* a nested group */, GroupsAccess>;

struct Field {
  std::string name;
  FieldValue value;
  std::string unit;  ///< SI unit, or empty
  FieldRange range;
  std::string meaning;
};

inline Field field(std::string name, double& value, std::string unit, FieldRange range, std::string meaning) {
  return {std::move(name), &value, std::move(unit), range, std::move(meaning)};
}
inline Field field(std::string name, int& value, std::string unit, FieldRange range, std::string meaning) {
  return {std::move(name), &value, std::move(unit), range, std::move(meaning)};
}
inline Field field(std::string name, bool& value, std::string meaning) {
  return {std::move(name), &value, "", {}, std::move(meaning)};
}
inline Field field(std::string name, std::string& value, std::string meaning) {
  return {std::move(name), &value, "", {}, std::move(meaning)};
}
template <std::size_t N>
Field field(std::string name, std::array<double, N>& value, std::string unit, FieldRange range, std::string meaning) {
  return {std::move(name), NumbersAccess{value.data(), static_cast<int>(N)}, std::move(unit), range, std::move(meaning)};
}
/// An enum whose values count up from 0 in the order of `words`.
template <typename Enum>
  requires std::is_enum_v<Enum>
Field field(std::string name, Enum& value, std::vector<std::string> words, std::string meaning) {
  EnumAccess access{std::move(words), [&value] { return static_cast<int>(value); },
                    [&value](int index) { value = static_cast<Enum>(index); }};
  return {std::move(name), std::move(access), "", {}, std::move(meaning)};
}
/// A nested config struct.
template <typename Config>
Field group(std::string name, Config& config, std::string meaning) {
  return {std::move(name), config.fields(), "", {}, std::move(meaning)};
}
template <typename Config>
class GroupsDraftOf : public GroupsDraft {
 public:
  explicit GroupsDraftOf(std::vector<Config>& list) : list_(list) {}
  Fields append() override { return items_.emplace_back().fields(); }
  void replace_list() override { list_.assign(items_.begin(), items_.end()); }

 private:
  std::vector<Config>& list_;
  std::deque<Config> items_;  // whose elements stay where they are
};
/// A list of nested config structs.
template <typename Config>
Field groups(std::string name, std::vector<Config>& list, std::string meaning) {
  GroupsAccess access{[&list] {
                        std::vector<Fields> items;
                        for (Config& item : list) items.push_back(item.fields());
                        return items;
                      },
                      [&list] { return std::make_shared<GroupsDraftOf<Config>>(list); }};
  return {std::move(name), std::move(access), "", {}, std::move(meaning)};
}

}  // namespace mmlins

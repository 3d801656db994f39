// SPDX-License-Identifier: MIT
#include "mmlins/io/pcd_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include "mmlins/base/text_file.hpp"

namespace mmlins::io {
namespace {

/// One column of the file.
struct Column {
  std::string name;
  char type = 'F';  ///< F: floating point, I: signed, U: unsigned
  std::size_t size = 4;
  std::size_t count = 1;
  std::size_t offset = 0;  ///< [bytes] in a point of a binary file
  std::size_t index = 0;   ///< of its first number in a line of a text file
};

struct Header {
  std::vector<Column> columns;
  std::size_t num_points = 0;
  std::size_t point_size = 0;  ///< [bytes]
  std::size_t num_values = 0;  ///< per point
  std::string data;            ///< ascii, binary or binary_compressed
};

constexpr std::size_t kLongestField = 1024;

template <typename Value, typename Set>
void read_values(std::istringstream& words, std::vector<Column>& columns, const Set& set) {
  Value value{};
  for (std::size_t i = 0; i < columns.size() && words >> value; ++i) set(columns[i], value);
}

/// Takes over one line of the header. @return whether it made sense
bool apply_line(Header& header, const std::string& line) {
  std::istringstream words(line);
  std::string key;
  words >> key;
  if (key == "FIELDS") {
    for (std::string name; words >> name;) header.columns.push_back({name});
  } else if (key == "SIZE") {
    read_values<std::size_t>(words, header.columns,
                             [](Column& column, std::size_t size) { column.size = size; });
  } else if (key == "TYPE") {
    read_values<char>(words, header.columns, [](Column& column, char type) { column.type = type; });
  } else if (key == "COUNT") {
    read_values<std::size_t>(words, header.columns,
                             [](Column& column, std::size_t count) { column.count = count; });
  } else if (key == "POINTS") {
    return static_cast<bool>(words >> header.num_points);
  } else if (key == "DATA") {
    return static_cast<bool>(words >> header.data);
  }
  return true;
}

Result<Header> read_header(std::istream& file, const std::string& path) {
  Header header;
  for (std::string line; header.data.empty();) {
    if (!std::getline(file, line) || line.size() > 100'000 || !apply_line(header, line)) {
      return make_error(ErrorCode::kInvalid, "{}: not a PCD file, or its header is damaged", path);
    }
  }
  for (Column& column : header.columns) {
    const bool is_size = column.size == 1 || column.size == 2 || column.size == 4 || column.size == 8;
    if (!is_size || column.count == 0 || column.count > kLongestField) {
      return make_error(ErrorCode::kInvalid, "{}: field {} has a wrong size or count", path, column.name);
    }
    column.offset = header.point_size;
    column.index = header.num_values;
    header.point_size += column.size * column.count;
    header.num_values += column.count;
  }
  return header;
}

std::optional<Column> find_column(const Header& header, const std::string& name) {
  for (const Column& column : header.columns) {
    if (column.name == name) return column;
  }
  return std::nullopt;
}

template <typename Value>
float load_float(const char* source) {
  Value value;
  std::memcpy(&value, source, sizeof(Value));
  return static_cast<float>(value);
}

float binary_value(const char* point, const Column& column) {
  const char* const source = point + column.offset;
  const auto either = [&](float as_signed, float as_unsigned) {
    return column.type == 'I' ? as_signed : as_unsigned;
  };
  switch (column.size) {
    case 1:
      return either(load_float<std::int8_t>(source), load_float<std::uint8_t>(source));
    case 2:
      return either(load_float<std::int16_t>(source), load_float<std::uint16_t>(source));
    case 4:
      if (column.type == 'F') return load_float<float>(source);
      return either(load_float<std::int32_t>(source), load_float<std::uint32_t>(source));
    default:
      if (column.type == 'F') return load_float<double>(source);
      return either(load_float<std::int64_t>(source), load_float<std::uint64_t>(source));
  }
}

/// The columns that are kept: x, y, z and, if there is one, the intensity.
using Kept = std::array<std::optional<Column>, 4>;

void append_point(PcdCloud& cloud, const std::array<float, 4>& values) {
  cloud.points.emplace_back(values[0], values[1], values[2]);
  cloud.intensities.push_back(values[3]);
}

bool read_binary(std::istream& file, const Header& header, const Kept& kept, PcdCloud& cloud) {
  std::vector<char> point(header.point_size);
  for (std::size_t i = 0; i < header.num_points; ++i) {
    if (!file.read(point.data(), static_cast<std::streamsize>(point.size()))) return false;
    std::array<float, 4> values{};
    for (std::size_t k = 0; k < kept.size(); ++k) {
      if (kept[k]) values[k] = binary_value(point.data(), *kept[k]);
    }
    append_point(cloud, values);
  }
  return true;
}

bool read_ascii(std::istream& file, const Header& header, const Kept& kept, PcdCloud& cloud) {
  std::vector<float> numbers(header.num_values);
  for (std::size_t i = 0; i < header.num_points; ++i) {
    for (float& number : numbers) {
      std::string word;  // by strtof, since streams do not read "nan"
      if (!(file >> word)) return false;
      char* end = nullptr;
      number = std::strtof(word.c_str(), &end);
      if (end == word.c_str()) return false;
    }
    std::array<float, 4> values{};
    for (std::size_t k = 0; k < kept.size(); ++k) {
      if (kept[k]) values[k] = numbers[kept[k]->index];
    }
    append_point(cloud, values);
  }
  return true;
}

bool write_points(std::FILE* file, std::span<const Eigen::Vector3f> points,
                  std::span<const float> intensities) {
  constexpr std::size_t kBlock = 4096;
  std::vector<std::array<float, 4>> block;
  for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
    const std::size_t end = std::min(points.size(), begin + kBlock);
    block.clear();
    for (std::size_t i = begin; i < end; ++i) {
      block.push_back(
          {points[i].x(), points[i].y(), points[i].z(), intensities.empty() ? 0.0F : intensities[i]});
    }
    if (std::fwrite(block.data(), sizeof(block[0]), block.size(), file) != block.size()) return false;
  }
  return true;
}

}  // namespace

Status write_pcd(const std::string& path, std::span<const Eigen::Vector3f> points,
                 std::span<const float> intensities) {
  MMLINS_CHECK(intensities.empty() || intensities.size() == points.size());
  const std::string temporary_path = path + ".part";
  std::FILE* const file = std::fopen(temporary_path.c_str(), "wb");
  if (file == nullptr) return cannot_write(path, errno);
  const std::string header = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F "
      "F F F\n"
      "COUNT 1 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
      points.size());
  errno = 0;
  bool ok = std::fwrite(header.data(), 1, header.size(), file) == header.size();
  ok = ok && write_points(file, points, intensities);
  ok = (std::fclose(file) == 0) && ok;
  if (ok && std::rename(temporary_path.c_str(), path.c_str()) == 0) return {};
  const int reason = errno;
  std::remove(temporary_path.c_str());
  return cannot_write(path, reason);
}

Result<PcdCloud> read_pcd(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return make_error(ErrorCode::kNotFound, "{}: cannot be read: {}", path, std::strerror(errno));
  const auto header = read_header(file, path);
  if (!header.ok()) return header.error();
  const Kept kept = {find_column(*header, "x"), find_column(*header, "y"), find_column(*header, "z"),
                     find_column(*header, "intensity")};
  if (!kept[0] || !kept[1] || !kept[2]) {
    return make_error(ErrorCode::kInvalid, "{}: has no fields x, y and z", path);
  }
  if (header->data != "binary" && header->data != "ascii") {
    return make_error(ErrorCode::kUnsupported, "{}: DATA {} is not supported; save it as binary or ascii",
                      path, header->data);
  }
  PcdCloud cloud;
  const bool ok = header->data == "binary" ? read_binary(file, *header, kept, cloud)
                                           : read_ascii(file, *header, kept, cloud);
  if (!ok) {
    return make_error(ErrorCode::kInvalid, "{}: ends after {} of {} points", path, cloud.points.size(),
                      header->num_points);
  }
  return cloud;
}

}  // namespace mmlins::io

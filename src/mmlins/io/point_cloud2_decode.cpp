// SPDX-License-Identifier: MIT
#include "mmlins/io/point_cloud2_decode.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <string_view>

#include "mmlins/io/point_columns.hpp"

namespace mmlins::io {
namespace {

const PointField* find_field(const std::vector<PointField>& fields, std::string_view name) {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [name](const auto& f) { return f.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

std::optional<PointField> find_any(const std::vector<PointField>& fields,
                                   std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (const PointField* field = find_field(fields, name)) return *field;
  }
  return std::nullopt;
}

std::string names_of(const std::vector<PointField>& fields) {
  std::string names;
  for (const PointField& field : fields) names += (names.empty() ? "" : ", ") + field.name;
  return names.empty() ? "none" : names;
}

Status check_within(const PointField& field, std::uint32_t point_step) {
  const std::uint32_t size = size_of(field.type);
  if (size == 0) {
    return make_error(ErrorCode::kInvalid, "point field {} has the unknown type {}", field.name,
                      static_cast<int>(field.type));
  }
  if (std::uint64_t{field.offset} + size > point_step) {
    return make_error(ErrorCode::kInvalid, "point field {} lies at bytes {} to {} of a point of {} bytes",
                      field.name, field.offset, std::uint64_t{field.offset} + size, point_step);
  }
  return {};
}

/// Every point lies within the data.
Status check_sizes(const PointCloud2View& view) {
  if (view.num_points() == 0) return {};
  const std::uint64_t row_size = std::uint64_t{view.width} * view.point_step;
  // Many drivers leave row_step wrong where it does not matter: in a single row.
  if (view.height > 1 && view.row_step < row_size) {
    return make_error(ErrorCode::kInvalid,
                      "rows of {} points of {} bytes do not fit into a row_step of {} bytes", view.width,
                      view.point_step, view.row_step);
  }
  // In this order nothing overflows.
  if (view.point_step == 0 || row_size > view.data.size() ||
      (std::uint64_t{view.height} - 1) * view.row_step + row_size > view.data.size()) {
    return make_error(ErrorCode::kInvalid,
                      "{} x {} points of {} bytes do not fit into the {} bytes of the message", view.width,
                      view.height, view.point_step, view.data.size());
  }
  return {};
}

/// Whether a LiDAR measured this: sensors mark beams without an echo by NaN or by zeros.
bool is_valid(const Eigen::Vector3f& p) {
  const float zero_if_finite = p.x() * 0.0F + p.y() * 0.0F + p.z() * 0.0F;
  return zero_if_finite == 0.0F && (p.x() != 0.0F || p.y() != 0.0F || p.z() != 0.0F);
}

struct ValidPoints {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> offsets;  ///< [bytes] where each begins in the data
};

/// @param load_point  reads x, y, z of the point at an address
template <typename LoadPoint>
ValidPoints collect_valid(const PointCloud2View& view, const LoadPoint& load_point) {
  ValidPoints valid;
  valid.points.resize(view.num_points());
  valid.offsets.resize(view.num_points());
  std::size_t size = 0;
  for (std::uint32_t row = 0; row < view.height; ++row) {
    std::size_t offset = std::size_t{row} * view.row_step;
    for (std::uint32_t column = 0; column < view.width; ++column, offset += view.point_step) {
      const Eigen::Vector3f p = load_point(view.data.data() + offset);
      valid.points[size] = p;
      valid.offsets[size] = static_cast<std::uint32_t>(offset);
      size += is_valid(p) ? 1 : 0;
    }
  }
  valid.points.resize(size);
  valid.offsets.resize(size);
  return valid;
}

float load_as_float(const std::uint8_t* point, const PointField& field) {
  float value = 0.0F;
  with_type(field.type,
            [&](auto type) { value = static_cast<float>(load<decltype(type)>(point + field.offset)); });
  return value;
}

ValidPoints valid_points(const PointCloud2View& view, const PointLayout& layout) {
  const auto is_float = [](const PointField& field) { return field.type == FieldType::kFloat32; };
  if (is_float(layout.x) && is_float(layout.y) && is_float(layout.z)) {
    return collect_valid(
        view, [x = layout.x.offset, y = layout.y.offset, z = layout.z.offset](const std::uint8_t* p) {
          return Eigen::Vector3f(load<float>(p + x), load<float>(p + y), load<float>(p + z));
        });
  }
  return collect_valid(view, [&layout](const std::uint8_t* p) {
    return Eigen::Vector3f(load_as_float(p, layout.x), load_as_float(p, layout.y),
                           load_as_float(p, layout.z));
  });
}

std::uint16_t to_ring(double value) {
  return value >= 0.0 && value <= 65535.0 ? static_cast<std::uint16_t>(value) : std::uint16_t{0};
}

}  // namespace

Result<PointCloud2View> parse_point_cloud2(Bytes message) {
  ByteReader reader(message);
  PointCloud2View view;
  view.stamp = reader.header();
  view.height = reader.number<std::uint32_t>();
  view.width = reader.number<std::uint32_t>();
  const Bytes fields_begin = reader.rest();
  const auto num_fields = reader.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < num_fields && reader.ok(); ++i) {
    (void)reader.text();
    (void)reader.take(4 + 1 + 4);  // offset, type, count
  }
  view.fields = fields_begin.first(fields_begin.size() - reader.rest().size());
  const bool is_big_endian = reader.number<std::uint8_t>() != 0;
  view.point_step = reader.number<std::uint32_t>();
  view.row_step = reader.number<std::uint32_t>();
  view.data = reader.sized();
  (void)reader.number<std::uint8_t>();  // is_dense: drivers set it wrongly, every point is looked at
  if (!reader.at_end()) {
    return make_error(ErrorCode::kInvalid, "message of {} bytes does not hold what it announces",
                      message.size());
  }
  if (is_big_endian) return make_error(ErrorCode::kUnsupported, "big-endian point data are not supported");
  if (const Status status = check_sizes(view); !status.ok()) return status.error();
  return view;
}

Result<std::vector<PointField>> parse_fields(Bytes fields) {
  ByteReader reader(fields);
  std::vector<PointField> parsed;
  const auto num_fields = reader.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < num_fields && reader.ok(); ++i) {
    PointField field;
    field.name = reader.text();
    field.offset = reader.number<std::uint32_t>();
    field.type = static_cast<FieldType>(reader.number<std::uint8_t>());
    field.count = reader.number<std::uint32_t>();
    parsed.push_back(std::move(field));
  }
  if (!reader.at_end()) return make_error(ErrorCode::kInvalid, "the list of point fields is damaged");
  return parsed;
}

Result<PointLayout> resolve_layout(const std::vector<PointField>& fields, std::uint32_t point_step,
                                   const std::string& time_field) {
  PointLayout layout;
  for (auto [name, place] :
       {std::pair{"x", &layout.x}, std::pair{"y", &layout.y}, std::pair{"z", &layout.z}}) {
    const PointField* field = find_field(fields, name);
    if (field == nullptr) {
      return make_error(ErrorCode::kInvalid, "no point field {} (fields: {})", name, names_of(fields));
    }
    *place = *field;
  }
  layout.intensity = find_any(fields, {"intensity", "intensities", "reflectivity"});
  layout.ring = find_any(fields, {"ring", "line", "channel", "laser_id"});
  if (!time_field.empty()) {
    const PointField* field = find_field(fields, time_field);
    if (field == nullptr) {
      return make_error(ErrorCode::kInvalid, "no point field {} (fields: {})", time_field, names_of(fields));
    }
    layout.time = *field;
  }
  for (const PointField& field : {layout.x, layout.y, layout.z, layout.intensity.value_or(layout.x),
                                  layout.ring.value_or(layout.x), layout.time.value_or(layout.x)}) {
    if (const Status status = check_within(field, point_step); !status.ok()) return status.error();
  }
  return layout;
}

Status PointCloud2Decoder::update_layout(const PointCloud2View& view) {
  if (view.point_step == layout_point_step_ &&
      std::equal(view.fields.begin(), view.fields.end(), layout_fields_.begin(), layout_fields_.end())) {
    return {};
  }
  const auto fields = parse_fields(view.fields);
  if (!fields.ok()) return fields.error();
  const auto layout = resolve_layout(*fields, view.point_step, time_field_);
  if (!layout.ok()) return layout.error();
  layout_ = *layout;
  layout_fields_.assign(view.fields.begin(), view.fields.end());
  layout_point_step_ = view.point_step;
  return {};
}

Result<LidarCloud> PointCloud2Decoder::decode(Bytes message) {
  const auto parsed = parse_point_cloud2(message);
  if (!parsed.ok()) return parsed.error();
  const PointCloud2View& view = *parsed;
  LidarCloud cloud;
  cloud.stamp = view.stamp;
  if (view.num_points() == 0) return cloud;
  if (const Status status = update_layout(view); !status.ok()) return status.error();
  ValidPoints valid = valid_points(view, layout_);
  const std::uint8_t* data = view.data.data();
  if (layout_.intensity) {
    cloud.intensities = read_column<float>(data, valid.offsets, *layout_.intensity,
                                           [](auto value) { return static_cast<float>(value); });
  }
  if (layout_.ring) {
    cloud.rings = read_column<std::uint16_t>(data, valid.offsets, *layout_.ring,
                                             [](auto value) { return to_ring(static_cast<double>(value)); });
  }
  if (layout_.time) {
    cloud.times = read_column<std::int64_t>(data, valid.offsets, *layout_.time, [this](auto value) {
      return to_nanoseconds(value, nanoseconds_per_unit_);
    });
  }
  cloud.num_invalid = static_cast<int>(view.num_points() - valid.points.size());
  cloud.points = std::move(valid.points);
  if (std::find(cloud.times.begin(), cloud.times.end(), kInvalidTime) != cloud.times.end()) {
    drop_outside(cloud, -kMaxPointTime, kMaxPointTime);
  }
  return cloud;
}

std::optional<std::pair<double, double>> time_extremes(const PointCloud2View& view,
                                                       const PointLayout& layout) {
  if (view.num_points() == 0 || !layout.time) return std::nullopt;
  const auto times = read_column<double>(view.data.data(), valid_points(view, layout).offsets, *layout.time,
                                         [](auto value) { return static_cast<double>(value); });
  std::optional<std::pair<double, double>> extremes;
  for (const double time : times) {
    if (!std::isfinite(time)) continue;
    if (!extremes) extremes = {time, time};
    extremes = {std::min(extremes->first, time), std::max(extremes->second, time)};
  }
  return extremes;
}

}  // namespace mmlins::io

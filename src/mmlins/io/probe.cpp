// SPDX-License-Identifier: MIT
#include "mmlins/io/probe.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <optional>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/io/imu_decode.hpp"
#include "mmlins/io/livox_decode.hpp"
#include "mmlins/io/point_cloud2_decode.hpp"
#include "mmlins/io/ros_message_types.hpp"
#include "mmlins/io/topic_timing.hpp"

namespace mmlins::io {
namespace {

using sensor::AccelUnit;

constexpr std::size_t kScansToSample = 10;
constexpr std::size_t kMessagesToTry = 200;
constexpr std::size_t kImuSamples = 400;
// Between 1 (g) and 9.81 (m/s^2), at equal ratios from both.
constexpr double kAccelUnitLimit = 3.13;
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
// Beyond these the unit is doubted: of the median length of an acceleration [m/s^2], of a scan [scan
// periods].
constexpr double kLeastAccelNorm = 5.0;
constexpr double kLargestAccelNorm = 15.0;
constexpr double kLeastScanPeriods = 1e-3;
constexpr double kMostScanPeriods = 3.0;

/// What the first scans look like.
struct ScanSamples {
  std::vector<PointField> fields;
  std::vector<TimeFieldRange> time_ranges;
  std::vector<Time> stamps;
  std::vector<std::size_t> num_points;
  std::bitset<65536> rings;

  [[nodiscard]] bool is_enough() const { return num_points.size() >= kScansToSample; }
  void add_points(const LidarCloud& cloud) {
    num_points.push_back(cloud.points.size());
    for (const std::uint16_t ring : cloud.rings) rings.set(ring);
  }
};

Status sample_livox(Bytes message, ScanSamples& samples) {
  const auto cloud = decode_livox(message);
  if (!cloud.ok()) return cloud.error();
  samples.stamps.push_back(cloud->stamp);
  if (cloud->points.empty()) return {};
  samples.add_points(*cloud);
  const auto [first, last] = std::minmax_element(cloud->times.begin(), cloud->times.end());
  samples.time_ranges.push_back({cloud->stamp, static_cast<double>(*first), static_cast<double>(*last)});
  return {};
}

Status sample_point_cloud2(Bytes message, const sensor::Rig& rig, ScanSamples& samples) {
  const auto view = parse_point_cloud2(message);
  if (!view.ok()) return view.error();
  auto fields = parse_fields(view->fields);
  if (!fields.ok()) return fields.error();
  if (view->num_points() == 0) {
    samples.stamps.push_back(view->stamp);
    return {};
  }
  const auto time_field = find_time_field(*fields, rig);
  if (!time_field.ok()) return time_field.error();
  const auto layout = resolve_layout(*fields, view->point_step, *time_field);
  if (!layout.ok()) return layout.error();
  PointCloud2Decoder decoder("", 1);
  const auto cloud = decoder.decode(message);
  if (!cloud.ok()) return cloud.error();
  samples.fields = std::move(*fields);
  samples.stamps.push_back(view->stamp);
  if (cloud->points.empty()) return {};
  samples.add_points(*cloud);
  if (const auto extremes = time_extremes(*view, *layout)) {
    samples.time_ranges.push_back({view->stamp, extremes->first, extremes->second});
  }
  return {};
}

Result<ScanSamples> sample_scans(Rosbag1Reader& reader, std::size_t topic, const sensor::Rig& rig) {
  ScanSamples samples;
  std::optional<Error> first_error;
  if (const Status status = reader.select({topic}); !status.ok()) return status.error();
  const BagTopic& chosen = reader.topics()[topic];
  for (std::size_t i = 0; i < kMessagesToTry && !samples.is_enough(); ++i) {
    const auto message = reader.next();
    if (!message.ok()) return message.error();
    if (!message->has_value()) break;
    const Bytes bytes((*message)->data, (*message)->size);
    const Status status =
        is_livox_type(chosen.type) ? sample_livox(bytes, samples) : sample_point_cloud2(bytes, rig, samples);
    if (!status.ok() && !first_error) first_error = status.error();
  }
  if (samples.stamps.empty() && first_error) {
    return make_error(first_error->code, "{}: topic {}: {}", reader.path(), chosen.name,
                      first_error->message);
  }
  return samples;
}

template <typename Number>
Number median(std::vector<Number> values) {
  if (values.empty()) return Number{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

FieldType type_of(const std::vector<PointField>& fields, const std::string& name) {
  for (const PointField& field : fields) {
    if (field.name == name) return field.type;
  }
  return FieldType::kFloat32;
}

AccelUnit find_accel_unit(double norm, const sensor::Rig& rig) {
  if (rig.accel_unit != AccelUnit::kAuto) return rig.accel_unit;
  return norm < kAccelUnitLimit ? AccelUnit::kStandardGravity : AccelUnit::kMetresPerSecondSquared;
}

/// Whatever the motion, gravity dominates the median: far from it, the unit is wrong.
void warn_of_odd_acceleration(const ImuInfo& info) {
  const bool is_in_g = info.accel_unit == AccelUnit::kStandardGravity;
  const double norm = info.median_accel_norm * (is_in_g ? kStandardGravity : 1.0);
  if (norm >= kLeastAccelNorm && norm <= kLargestAccelNorm) return;
  log::warning(
      "{}: the first accelerations are {:.3g} m/s^2 long, taken as {}, and gravity is 9.81; set accel_unit "
      "in the rig if "
      "that is wrong",
      info.topic, norm, is_in_g ? "g" : "m/s^2");
}

/// Scans follow one another: one cannot take much longer than the time to the next.
void warn_of_odd_duration(const LidarInfo& info) {
  const double span = to_seconds(info.time.span);
  if (info.rate_hz <= 0.0 || info.time.field.empty() || info.time.instantaneous ||
      info.num_scans_sampled == 0)
    return;
  const double periods = span * info.rate_hz;
  if (periods >= kLeastScanPeriods && periods <= kMostScanPeriods) return;
  log::warning(
      "{}: by the field {} a scan takes {:.3g} s, but one comes every {:.3g} s; set time_unit in the rig if "
      "that is wrong",
      info.topic, info.time.field, span, 1.0 / info.rate_hz);
}

}  // namespace

Result<LidarInfo> probe_lidar(Rosbag1Reader& reader, std::size_t topic, const sensor::Rig& rig) {
  const auto samples = sample_scans(reader, topic, rig);
  if (!samples.ok()) return samples.error();
  LidarInfo info;
  info.topic = reader.topics()[topic].name;
  info.type = reader.topics()[topic].type;
  info.fields = samples->fields;
  info.rate_hz = measure_timing(samples->stamps, true).rate_hz();
  info.points_per_scan = median(samples->num_points);
  info.num_rings = static_cast<int>(samples->rings.count());
  info.num_scans_sampled = samples->num_points.size();
  if (is_livox_type(info.type)) {
    sensor::Rig livox = rig;  // the message defines unit and origin
    livox.time_unit = sensor::TimeUnit::kNanoseconds;
    livox.time_reference = sensor::TimeReference::kRelative;
    info.time =
        find_time_model(std::string(kLivoxTimeField), FieldType::kUint32, samples->time_ranges, livox);
    return info;
  }
  const auto time_field = find_time_field(info.fields, rig);
  if (!time_field.ok()) return time_field.error();
  info.time = find_time_model(*time_field, type_of(info.fields, *time_field), samples->time_ranges, rig);
  warn_of_odd_duration(info);
  return info;
}

Result<ImuInfo> probe_imu(Rosbag1Reader& reader, std::size_t topic, const sensor::Rig& rig) {
  if (const Status status = reader.select({topic}); !status.ok()) return status.error();
  ImuInfo info;
  info.topic = reader.topics()[topic].name;
  std::vector<double> norms;
  std::vector<Time> stamps;
  std::optional<Error> first_error;
  for (std::size_t i = 0; i < kImuSamples; ++i) {
    const auto message = reader.next();
    if (!message.ok()) return message.error();
    if (!message->has_value()) break;
    const auto sample = decode_imu(Bytes((*message)->data, (*message)->size));
    if (!sample.ok()) {
      if (!first_error) first_error = sample.error();
      continue;
    }
    stamps.push_back(sample->time);
    if (sample->accel.allFinite()) norms.push_back(sample->accel.norm());
  }
  if (stamps.empty() && first_error) {
    return make_error(first_error->code, "{}: topic {}: {}", reader.path(), info.topic, first_error->message);
  }
  info.rate_hz = measure_timing(stamps, true).rate_hz();
  info.median_accel_norm = median(norms);
  info.accel_unit = find_accel_unit(info.median_accel_norm, rig);
  if (!norms.empty()) warn_of_odd_acceleration(info);
  return info;
}

}  // namespace mmlins::io

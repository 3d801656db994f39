// SPDX-License-Identifier: MIT
#include "mmlins/sim/scan_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace mmlins::sim {

namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kRadPerDeg = kPi / 180.0;

Vector3d direction_of(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

// The same for a laser of fixed elevation.
Vector3d turned_to(double azimuth, const Vector3d& at_azimuth_zero) {
  const double across = at_azimuth_zero.x();
  return {across * std::cos(azimuth), across * std::sin(azimuth), at_azimuth_zero.z()};
}

// Number of the first tick of a clock with the given period at or after `time`.
std::int64_t first_tick(Duration time, Duration period) {
  return (time.count() + period.count() - 1) / period.count();
}

// Rings are numbered from the lowest laser up.
std::vector<std::uint16_t> rings_by_elevation(const std::vector<double>& elevations) {
  std::vector<std::size_t> order(elevations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return elevations[a] < elevations[b]; });
  std::vector<std::uint16_t> rings(elevations.size());
  for (std::size_t i = 0; i < order.size(); ++i) rings[order[i]] = static_cast<std::uint16_t>(i);
  return rings;
}

class Spinning : public ScanPattern {
 public:
  Spinning(const SpinningTable& table, double rotor_hz, double phase)
      : table_(table), rings_(rings_by_elevation(table.elevations_deg)), rotor_hz_(rotor_hz), phase_(phase) {
    for (const double elevation : table.elevations_deg)
      lasers_.push_back(direction_of(0.0, elevation * kRadPerDeg));
  }

  std::vector<Beam> beams(Duration begin, Duration end) const override {
    std::vector<Beam> beams;
    const std::int64_t last = first_tick(end, table_.between_columns);
    for (std::int64_t column = first_tick(begin, table_.between_columns); column < last; ++column) {
      const Duration column_time = column * table_.between_columns;
      for (std::size_t laser = 0; laser < table_.elevations_deg.size(); ++laser) {
        const Duration time =
            column_time + static_cast<std::int64_t>(laser / table_.lasers_at_once) * table_.between_lasers;
        beams.push_back(
            {time, turned_to(azimuth(time, laser), lasers_[laser]), rings_[laser], Vector3d::Zero()});
        if (table_.beam_origin > 0.0)
          beams.back().origin = table_.beam_origin * direction_of(rotor_angle(time), 0.0);
      }
    }
    return beams;
  }

 private:
  // The rotor turns clockwise seen from above, and never stops between scans.
  double rotor_angle(Duration time) const {
    const double turns = rotor_hz_ * to_seconds(time) + phase_;
    return -2.0 * kPi * (turns - std::floor(turns));
  }
  double azimuth(Duration time, std::size_t laser) const {
    const double offset =
        table_.azimuths_deg.empty() ? 0.0 : table_.azimuths_deg[laser % table_.azimuths_deg.size()];
    return rotor_angle(time) + offset * kRadPerDeg;
  }

  SpinningTable table_;
  std::vector<std::uint16_t> rings_;
  std::vector<Vector3d> lasers_;  // directions at azimuth 0
  double rotor_hz_;
  double phase_;  // [turns]
};

class Nodding : public ScanPattern {
 public:
  explicit Nodding(const NoddingTable& table) : table_(table) {}

  std::vector<Beam> beams(Duration begin, Duration end) const override {
    std::vector<Beam> beams;
    const std::int64_t last = first_tick(end, table_.between_points);
    for (std::int64_t i = first_tick(begin, table_.between_points); i < last; ++i) {
      const Duration time = i * table_.between_points;
      const double t = to_seconds(time);
      const double azimuth =
          std::fmod(-62050.63 * t, 360.0) + 3.11 * std::cos(314159.2 * t) * std::sin(628.318 * 2.0 * t);
      const double elevation = 25.5 * std::cos(20.0 * kPi * t) +
                               4.0 * std::cos(2.0 * kPi / 0.006 * t) * std::cos(10000.0 * kPi * t) + 22.5;
      beams.push_back(
          {time, direction_of(azimuth * kRadPerDeg, elevation * kRadPerDeg), 0, Vector3d::Zero()});
    }
    return beams;
  }

 private:
  NoddingTable table_;
};

class Rosette : public ScanPattern {
 public:
  explicit Rosette(const RosetteTable& table) : table_(table) {}

  std::vector<Beam> beams(Duration begin, Duration end) const override {
    std::vector<Beam> beams;
    const std::size_t num_lines = table_.line_offsets_deg.size();
    const std::int64_t last = first_tick(end, table_.between_points);
    for (std::int64_t i = first_tick(begin, table_.between_points); i < last; ++i) {
      const Duration time = i * table_.between_points;
      const double a = 2.0 * kPi * std::fmod(table_.first_hz * to_seconds(time), 1.0);
      const double b = 2.0 * kPi * std::fmod(table_.second_hz * to_seconds(time), 1.0);
      const std::size_t line = static_cast<std::size_t>(i) % num_lines;
      const double half = 0.5 * table_.half_angle_deg * kRadPerDeg;
      const double elevation =
          half * (std::sin(a) + std::sin(b)) + table_.line_offsets_deg[line] * kRadPerDeg;
      beams.push_back({time, direction_of(half * (std::cos(a) + std::cos(b)), elevation),
                       static_cast<std::uint16_t>(line), Vector3d::Zero()});
    }
    return beams;
  }

 private:
  RosetteTable table_;
};

}  // namespace

std::unique_ptr<ScanPattern> make_spinning(const SpinningTable& table, double rotor_hz, double phase) {
  return std::make_unique<Spinning>(table, rotor_hz, phase);
}
std::unique_ptr<ScanPattern> make_nodding(const NoddingTable& table) {
  return std::make_unique<Nodding>(table);
}
std::unique_ptr<ScanPattern> make_rosette(const RosetteTable& table) {
  return std::make_unique<Rosette>(table);
}

}  // namespace mmlins::sim

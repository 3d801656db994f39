// SPDX-License-Identifier: MIT
#pragma once
// When and where a LiDAR fires. Sensors are tables of numbers, not code.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "mmlins/base/time.hpp"

namespace mmlins::sim {

/// One shot.
struct Beam {
  Duration time;              ///< after the sensor was switched on
  Eigen::Vector3d direction;  ///< unit vector in the LiDAR frame
  std::uint16_t ring = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< where the beam starts, in the LiDAR frame [m]
};

class ScanPattern {
 public:
  virtual ~ScanPattern() = default;
  /// All shots with begin <= time < end, in order of time.
  [[nodiscard]] virtual std::vector<Beam> beams(Duration begin, Duration end) const = 0;
};

/// A turning row of lasers.
struct SpinningTable {
  std::vector<double> elevations_deg;  ///< in the order of firing
  std::vector<double> azimuths_deg;    ///< offset of each laser; repeated if shorter; empty: none
  Duration between_lasers{0};          ///< from one firing to the next
  Duration between_columns{0};
  std::size_t lasers_at_once = 1;  ///< that fire together
  double beam_origin = 0.0;        ///< distance from the axis at which beams start [m]
};

/// The pattern of a MID-360: one mirror that turns and nods (formula of the MARSIM simulator).
struct NoddingTable {
  Duration between_points{5000};
};

/// Two prisms turning against each other draw a rosette that does not repeat.
struct RosetteTable {
  double half_angle_deg = 35.0;               ///< of the whole field of view
  double first_hz = 121.567;                  ///< of the first prism
  double second_hz = -77.733;                 ///< of the second prism; negative: the other way round
  std::vector<double> line_offsets_deg{0.0};  ///< elevation offset of each laser
  Duration between_points{4167};
};

/// @param rotor_hz  turns per second, also across scans
/// @param phase     of the rotor when the sensor is switched on [turns]
[[nodiscard]] std::unique_ptr<ScanPattern> make_spinning(const SpinningTable& table, double rotor_hz,
                                                         double phase);
[[nodiscard]] std::unique_ptr<ScanPattern> make_nodding(const NoddingTable& table);
[[nodiscard]] std::unique_ptr<ScanPattern> make_rosette(const RosetteTable& table);

}  // namespace mmlins::sim

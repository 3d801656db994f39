// SPDX-License-Identifier: MIT
#pragma once
// Unevenness of surfaces: a smooth function of the place, so that it is geometry and not noise; the same
// place is the same on every visit.

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace mmlins::sim {

/// How far a surface stands out along its normal, and how that changes with the place.
struct Bump {
  double height = 0.0;  ///< [m]
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// A sum of a few plane waves of random directions.
class Relief {
 public:
  struct Config {
    double deviation = 0.0;       ///< root mean square of the height [m]
    double min_wavelength = 1.0;  ///< [m]
    double max_wavelength = 3.0;  ///< [m]
    bool horizontal = false;      ///< the waves run in the ground plane only
  };

  Relief() = default;
  Relief(const Config& config, std::uint64_t seed);

  [[nodiscard]] Bump at(const Eigen::Vector3d& p) const;

 private:
  static constexpr std::size_t kNumWaves = 4;
  struct Wave {
    Eigen::Vector3d frequency = Eigen::Vector3d::Zero();  ///< [1/m]
    double phase = 0.0;                                   ///< [turns]
  };
  double amplitude_ = 0.0;  // [m]
  std::array<Wave, kNumWaves> waves_;
};

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include "mmlins/sim/relief.hpp"

#include <cmath>

#include "mmlins/sim/random.hpp"

namespace mmlins::sim {

namespace {
// One wave is 16 u^2 (1 - u)^2 over a period u in [0, 1): nearly a cosine, twice continuously
// differentiable across periods, and ten times cheaper. Its mean and its deviation:
constexpr double kWaveMean = 8.0 / 15.0;
constexpr double kWaveDeviation = 0.34917;

// Without a call into the library, which the baseline instruction set would need. |x| < 2^31.
double floor_of(double x) {
  const auto toward_zero = static_cast<double>(static_cast<int>(x));
  return toward_zero > x ? toward_zero - 1.0 : toward_zero;
}

}  // namespace

Relief::Relief(const Config& config, std::uint64_t seed)
    : amplitude_(config.deviation / (kWaveDeviation * std::sqrt(static_cast<double>(kNumWaves)))) {
  Random random(seed);
  for (std::size_t i = 0; i < kNumWaves; ++i) {
    Eigen::Vector3d direction = random.normal3();
    if (config.horizontal) direction.z() = 0.0;
    // Wavelengths spread evenly over the range in ratio, so that none is a multiple of another.
    const double share = (static_cast<double>(i) + random.uniform()) / static_cast<double>(kNumWaves);
    const double wavelength =
        config.min_wavelength * std::pow(config.max_wavelength / config.min_wavelength, share);
    waves_[i] = {direction.normalized() / wavelength, random.uniform()};
  }
}

Bump Relief::at(const Eigen::Vector3d& p) const {
  if (amplitude_ == 0.0) return {};
  double height = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (const Wave& wave : waves_) {
    const double turns = wave.frequency.dot(p) + wave.phase;
    const double u = turns - floor_of(turns);
    const double v = u * (1.0 - u);
    height += 16.0 * v * v - kWaveMean;
    gradient += (32.0 * v * (1.0 - 2.0 * u)) * wave.frequency;
  }
  return {amplitude_ * height, amplitude_ * gradient};
}

}  // namespace mmlins::sim

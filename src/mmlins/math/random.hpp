// SPDX-License-Identifier: MIT
#pragma once
// Random numbers that are the same everywhere: SplitMix64 and explicit transformations, because the
// standard library leaves its distributions to the implementation. A generator costs nothing to make, so
// every scan, sample and object can have its own, and the result does not depend on who draws first.

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace mmlins::math {

/// Scrambles 64 bits (the output function of SplitMix64).
[[nodiscard]] constexpr std::uint64_t scramble(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// An independent seed for part number `part` of what `seed` stands for.
[[nodiscard]] constexpr std::uint64_t sub_seed(std::uint64_t seed, std::uint64_t part) {
  return scramble(scramble(seed + 0x9e3779b97f4a7c15ULL) + 0xd1b54a32d192ed03ULL * (part + 1));
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  [[nodiscard]] std::uint64_t bits() { return scramble(state_ += 0x9e3779b97f4a7c15ULL); }
  /// In [0, 1).
  [[nodiscard]] double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  [[nodiscard]] double uniform(double low, double high) { return low + (high - low) * uniform(); }
  [[nodiscard]] bool chance(double probability) { return uniform() < probability; }
  /// Normal with mean 0 and deviation 1 (Box-Muller).
  [[nodiscard]] double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }
  [[nodiscard]] Eigen::Vector3d normal3() {
    const double x = normal();
    const double y = normal();
    return {x, y, normal()};
  }

 private:
  std::uint64_t state_;
};

}  // namespace mmlins::math

// SPDX-License-Identifier: MIT
#pragma once
// A number that knows its first two derivatives with respect to time. Motions are written once, as plain
// formulas, and their velocities and accelerations come out exact instead of by finite differences.

#include <cmath>

namespace mmlins::sim {

struct Jet {
  double value = 0.0;
  double rate = 0.0;   ///< first derivative [1/s]
  double accel = 0.0;  ///< second derivative [1/s^2]
};

[[nodiscard]] inline Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.rate + b.rate, a.accel + b.accel};
}
[[nodiscard]] inline Jet operator+(const Jet& a, double b) { return {a.value + b, a.rate, a.accel}; }
[[nodiscard]] inline Jet operator*(double a, const Jet& b) { return {a * b.value, a * b.rate, a * b.accel}; }
[[nodiscard]] inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.rate * b.value + a.value * b.rate,
          a.accel * b.value + 2.0 * a.rate * b.rate + a.value * b.accel};
}

/// Chain rule for a function with the given value and first two derivatives at x.value.
[[nodiscard]] inline Jet chain(const Jet& x, double f, double df, double ddf) {
  return {f, df * x.rate, ddf * x.rate * x.rate + df * x.accel};
}
[[nodiscard]] inline Jet sin(const Jet& x) {
  const double s = std::sin(x.value);
  return chain(x, s, std::cos(x.value), -s);
}
[[nodiscard]] inline Jet cos(const Jet& x) {
  const double c = std::cos(x.value);
  return chain(x, c, -std::sin(x.value), -c);
}
/// The angle of the vector (x, y), which must not vanish.
[[nodiscard]] inline Jet atan2(const Jet& y, const Jet& x) {
  const double square = x.value * x.value + y.value * y.value;
  const double turn = x.value * y.rate - y.value * x.rate;
  const double turn_rate = x.value * y.accel - y.value * x.accel;
  const double square_rate = 2.0 * (x.value * x.rate + y.value * y.rate);
  return {std::atan2(y.value, x.value), turn / square,
          (turn_rate * square - turn * square_rate) / (square * square)};
}

}  // namespace mmlins::sim

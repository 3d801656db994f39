// SPDX-License-Identifier: MIT
#pragma once
// Ways from 0 to 1 so smooth that a motion made of them is four times continuously differentiable.

#include "mmlins/sim/jet.hpp"

namespace mmlins::sim {

/// From 0 at s = 0 to 1 at s = 1; four derivatives vanish at both ends.
[[nodiscard]] inline Jet smooth_step(const Jet& s) {
  if (s.value <= 0.0) return {};
  if (s.value >= 1.0) return {1.0, 0.0, 0.0};
  const double x = s.value, y = 1.0 - x;
  const double f = x * x * x * x * x * (126.0 + x * (-420.0 + x * (540.0 + x * (-315.0 + x * 70.0))));
  const double x3y3 = x * x * x * y * y * y;
  return chain(s, f, 630.0 * x3y3 * x * y, 2520.0 * x3y3 * (y - x));
}

/// A speed that rises from 0 at s = 0 to 1 at s = 1, integrated over s. Three derivatives of the speed vanish
/// at both ends; from s = 1 on this is s - 1/2.
[[nodiscard]] inline Jet smooth_start(const Jet& s) {
  if (s.value <= 0.0) return {};
  if (s.value >= 1.0) return s + (-0.5);
  const double x = s.value, y = 1.0 - x;
  const double x4 = x * x * x * x;
  const double integral = x4 * x * (7.0 + x * (-14.0 + x * (10.0 - 2.5 * x)));
  const double speed = x4 * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)));
  return chain(s, integral, speed, 140.0 * x * x * x * y * y * y);
}

/// From 0 at s = 0 up to 1 in the middle and back to 0 at s = 1; four derivatives vanish at both ends.
[[nodiscard]] inline Jet smooth_hump(const Jet& s) {
  if (s.value <= 0.0 || s.value >= 1.0) return {};
  const double x = s.value, y = 1.0 - x;
  const double xy = x * y;
  const double cube = 1024.0 * xy * xy * xy;
  return chain(s, cube * xy * xy, 5.0 * cube * xy * (y - x),
               5.0 * cube * (4.0 * (y - x) * (y - x) - 2.0 * xy));
}

}  // namespace mmlins::sim

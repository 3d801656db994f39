// SPDX-License-Identifier: MIT
#pragma once
// All parameters of finding the state in motion, and their only defaults.

#include "mmlins/base/config_fields.hpp"

namespace mmlins::initialization {

enum class InitializationMode { kDefault, kPaper };

/// How long a window must be before it is tried, and how long it may grow before it slides.
struct WindowConfig {
  int min_poses = 4;
  double carried_min = 0.3;
  double cold_min = 1.0;
  double cold_max = 4.0;
  int paper_frames = 4;

  [[nodiscard]] Fields fields();
};

/// Standard deviations of what is taken to be known at rest.
struct PriorConfig {
  double rest_speed = 0.02;
  double rest_gyro = 1e-3;
  double rest_accel = 0.02;

  [[nodiscard]] Fields fields();
};

struct AcceptanceConfig {
  double max_imu_gap = 0.1;
  double gravity_error = 0.15;
  double gravity_sigmas = 3.0;
  double max_tilt_deg = 1.0;
  double max_speed_deviation = 0.1;
  double min_chi2 = 0.02;
  double max_chi2 = 3.0;
  double max_bias_sigmas = 5.0;
  double min_speed_support = 1.0;

  [[nodiscard]] Fields fields();
};

struct InitializationConfig {
  InitializationMode mode = InitializationMode::kDefault;
  WindowConfig window;
  PriorConfig prior;
  AcceptanceConfig acceptance;
  int max_iterations = 10;

  [[nodiscard]] Fields fields();
};

}  // namespace mmlins::initialization

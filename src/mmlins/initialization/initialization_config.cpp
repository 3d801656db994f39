// SPDX-License-Identifier: MIT
#include "mmlins/initialization/initialization_config.hpp"

namespace mmlins::initialization {

Fields WindowConfig::fields() {
  return {
      field("min_poses", min_poses, "", {3.0, 1000.0}, "with fewer poses no start is tried"),
      field("carried_min", carried_min, "s", {0.05, 60.0},
            "shortest window where the state was carried over by the IMU"),
      field("cold_min", cold_min, "s", {0.05, 60.0}, "shortest window where nothing is known beforehand"),
      field("cold_max", cold_max, "s", {0.05, 60.0}, "longest such window: then its oldest scans are dropped"),
      field("paper_frames", paper_frames, "", {4.0, 1000.0}, "poses in the window of the paper's method"),
  };
}

Fields PriorConfig::fields() {
  return {
      field("rest_speed", rest_speed, "m/s", {1e-6, 1.0},
            "at rest: standard deviation of the speed, which is nil"),
      field("rest_gyro", rest_gyro, "rad/s", {1e-6, 1.0},
            "at rest: of the mean angular rate as the gyro's bias"),
      field("rest_accel", rest_accel, "m/s^2", {1e-6, 5.0},
            "at rest: of the mean force as minus gravity plus bias"),
  };
}

Fields AcceptanceConfig::fields() {
  return {
      field("max_imu_gap", max_imu_gap, "s", {0.001, 10.0},
            "with a longer gap between IMU samples no start is accepted"),
      field("gravity_error", gravity_error, "m/s^2", {0.0, 10.0},
            "gravity estimated without its known magnitude may miss it by this much, or by gravity_sigmas"),
      field("gravity_sigmas", gravity_sigmas, "", {0.0, 100.0}, "standard deviations that it may miss it by"),
      field("max_tilt_deg", max_tilt_deg, "deg", {0.001, 90.0},
            "largest standard deviation of the direction of gravity"),
      field("max_speed_deviation", max_speed_deviation, "m/s", {0.001, 100.0},
            "largest standard deviation of the velocity"),
      field("min_chi2", min_chi2, "", {0.0, 1.0},
            "poses that agree better than this per degree of freedom were not measured but copied from the "
            "IMU"),
      field("max_chi2", max_chi2, "", {1.0, 1000.0}, "poses that agree worse than this are wrong"),
      field("max_bias_sigmas", max_bias_sigmas, "", {0.1, 100.0},
            "a bias that moved by more of its prior's sigmas is not one"),
      field("min_speed_support", min_speed_support, "", {0.0, 100.0},
            "max_speed_deviation over the deviation of the velocity without its prior: below this the "
            "velocity is a guess"),
  };
}

Fields InitializationConfig::fields() {
  return {
      field(
          "mode", mode, {"default", "paper"},
          "default: weighted estimate with priors and tests; paper: four frames, unweighted, without tests"),
      group("window", window, "how much to look at"),
      group("prior", prior, "what is known at rest"),
      group("acceptance", acceptance, "when a start is good enough"),
      field("max_iterations", max_iterations, "", {1.0, 100.0}, "Gauss-Newton iterations"),
  };
}

}  // namespace mmlins::initialization

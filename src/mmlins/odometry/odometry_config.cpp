// SPDX-License-Identifier: MIT
#include "mmlins/odometry/odometry_config.hpp"

namespace mmlins::odometry {

Fields ImuModelConfig::fields() {
  return {
      field("gyro_noise_factor", gyro_noise_factor, "", {0.1, 100.0},
            "the rig's gyro noise times this: room for vibration, scale errors and interpolation"),
      field("accel_noise_factor", accel_noise_factor, "", {0.1, 100.0}, "the same for the accelerometer"),
      field("bias_walk_factor", bias_walk_factor, "", {0.1, 100.0}, "the same for the walk of both biases"),
      field("gyro_scale_deviation", gyro_scale_deviation, "", {0.0, 0.2},
            "deviation of the gyroscope's scale and misalignment, which are learnt on the way; 0: it has no such errors"),
      field("max_gap", max_gap, "s", {0.001, 10.0}, "a longer step between IMU samples is a gap, and reported as one"),
  };
}

Fields ScanConfig::fields() {
  return {
      field("target_keypoints", target_keypoints, "", {100.0, 100000.0},
            "points per scan to match; the leaf of the grid that thins the scan follows it"),
      field("min_leaf", min_leaf, "m", {0.01, 5.0}, "smallest edge of that grid"),
      field("max_leaf", max_leaf, "m", {0.01, 5.0}, "largest edge of that grid"),
      field("map_leaf_share", map_leaf_share, "", {0.1, 1.0},
            "leaf for the points that enter the map, as a share of the leaf for matching"),
  };
}

Fields MatchingConfig::fields() {
  return {
      field("max_iterations", max_iterations, "", {1.0, 50.0}, "iterations of the filter update per scan"),
      field("min_matches", min_matches, "", {6.0, 10000.0}, "with fewer matches the scan is not used: the IMU carries the pose"),
      field("gate_sigmas", gate_sigmas, "", {1.0, 20.0},
            "a residual beyond this many standard deviations, predicted from noise, map and state, is no match"),
      field("huber_sigmas", huber_sigmas, "", {0.5, 20.0}, "residuals beyond this many standard deviations count linearly"),
      field("soften_weak_directions", soften_weak_directions,
            "leave directions whose information noisy normals feign to the IMU"),
  };
}

Fields LocalMapConfig::fields() {
  return {
      field("kind", kind, {"planes", "knn"},
            "planes: cached planes in a pyramid of grids; knn: five nearest neighbours, the baseline of the field"),
      field("radius", radius, "m", {5.0, 2000.0}, "what lies farther from the sensor is forgotten"),
      field("insert_distance", insert_distance, "m", {0.0, 10.0}, "a scan enters the map after this much travel"),
      field("insert_angle_deg", insert_angle_deg, "deg", {0.0, 180.0}, "or after turning by this angle"),
      field("initial_insertions", initial_insertions, "", {1.0, 1000.0}, "the first scans enter the map in any case"),
      group("planes", planes, "the map of planes"),
      group("knn", knn, "the map of points"),
  };
}

Fields StartConfig::fields() {
  return {
      field("rest_window", rest_window, "s", {0.1, 60.0}, "time to look at before starting from rest"),
      field("motion_window", motion_window, "s", {0.3, 60.0}, "time to look at before starting in motion"),
      field("rest_gyro_deviation", rest_gyro_deviation, "rad/s", {0.0, 10.0}, "a quieter gyroscope may mean rest"),
      field("rest_accel_deviation", rest_accel_deviation, "m/s^2", {0.0, 10.0}, "a quieter accelerometer may mean rest"),
      field("rest_speed", rest_speed, "m/s", {0.0, 10.0}, "and the scans must agree that nothing moves faster than this"),
      field("motion_accel", motion_accel, "m/s^2", {0.01, 20.0},
            "standard deviation of the mean acceleration over the window, when started in motion"),
      field("motion_speed", motion_speed, "m/s", {0.1, 100.0}, "standard deviation of the unknown speed at the start"),
      field("settled_speed", settled_speed, "m/s", {0.001, 1.0},
            "the speed at the start has settled when a pass over the window changes it by less"),
      field("max_passes", max_passes, "", {1.0, 50.0}, "passes over the window; a speed that has not settled then is no start"),
      field("retry", retry, "s", {0.1, 60.0}, "after a start was refused, the next is tried with this much more to look at"),
  };
}

Fields RestartConfig::fields() {
  return {
      field("max_drift", max_drift, "m", {0.0, 1000.0},
            "without a match the map falls asleep when the pose may have drifted by this standard deviation"),
      field("max_drift_deg", max_drift_deg, "deg", {0.0, 180.0}, "the same for rotation"),
      field("unexplained", unexplained, "s", {0.0, 60.0},
            "a new map that has proved itself takes over after this much of seeing what the old one does not explain, even "
            "within the budget"),
      field("unexplained_near", unexplained_near, "s", {0.0, 60.0},
            "the same while the pose may not have drifted by trust.doubtful_drift"),
      field("trial", trial, "s", {0.2, 60.0}, "a new map must prove itself for this long"),
      field("patience", patience, "s", {0.2, 600.0}, "after this much of not proving itself the trial begins anew"),
      field("min_explained", min_explained, "", {0.0, 1.0},
            "a new map that explains less of its scans than this share is none: what moves about the sensor matches here and there"),
      field("min_explained_collapsed", min_explained_collapsed, "", {0.0, 1.0},
            "the same of scans that have collapsed to what is near: it may be a cover"),
      field("pose_deviation", pose_deviation, "m", {0.0, 1.0},
            "what poses from a young map may be off by besides their noise, when velocity and gravity are found from them"),
      field("pose_deviation_deg", pose_deviation_deg, "deg", {0.0, 10.0}, "the same for rotation"),
      field("confirming_motion", confirming_motion, "m", {0.0, 100.0},
            "under what looks like a cover, the scans must see the robot travel this far"),
      field("confirming_turn_deg", confirming_turn_deg, "deg", {0.0, 180.0}, "or turn by this angle"),
  };
}

Fields RebuiltMapConfig::fields() {
  return {
      field("deviation", deviation, "m", {0.001, 1.0},
            "standard deviation of where the back end has known surroundings; three of them are the most that they are moved"),
      field("deviation_deg", deviation_deg, "deg", {0.01, 10.0}, "the same for rotation"),
      field("settle", settle, "m", {0.0, 1.0},
            "nearer than this to where it is seen, the map is not moved: the next matches settle the robot in it"),
      field("settle_deg", settle_deg, "deg", {0.0, 10.0}, "the same for rotation"),
      field("min_explained", min_explained, "", {0.0, 2.0},
            "a rebuilt map must explain at least this share of what the one before explains"),
      field("max_residual", max_residual, "", {0.1, 10.0}, "and leave residuals of at most this many times its"),
      field("patience", patience, "", {1.0, 1000.0}, "scans after which a map that does not is dropped"),
  };
}

Fields OdometryConfig::fields() {
  return {
      field("detector", detector, {"default", "paper", "published", "zhang"},
            "what puts a map to sleep; others than default are for comparison: the rule of the MM-LINS paper, that of "
            "its published code, and the degeneracy factor"),
      group("imu", imu, "how much the IMU is trusted"),
      group("scan", scan, "preparation of a scan"),
      group("matching", matching, "matching of a scan against the map"),
      group("map", map, "the local map that scans are matched against"),
      group("rebuilt", rebuilt, "when a local map rebuilt from keyframes takes its place (mapping.rebuild)"),
      group("start", start, "the first seconds"),
      group("trust", trust, "when a match is believed"),
      group("restart", restart, "when a map falls asleep and a new one begins"),
      group("initialization", initialization, "velocity, gravity and biases of a new map"),
      group("observability", observability, "when a direction counts as weak"),
  };
}

}  // namespace mmlins::odometry

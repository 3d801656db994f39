// SPDX-License-Identifier: MIT
#include "mmlins/sim/imu_model.hpp"

#include <algorithm>
#include <cmath>

#include "mmlins/sim/random.hpp"

namespace mmlins::sim {

namespace {
enum RandomPart : std::uint64_t { kBiases, kNoise };
}

ImuModel::ImuModel(const ImuConfig& config, std::uint64_t seed, Duration duration)
    : config_(config), seed_(seed) {
  const auto count = static_cast<std::size_t>(std::ceil(to_seconds(duration) * config.rate_hz)) + 2;
  biases_.resize(count);
  if (config.perfect) return;
  Random random(sub_seed(seed, kBiases));
  biases_[0] = {config.gyro_turn_on_bias * random.normal3(), config.accel_turn_on_bias * random.normal3()};
  const double root_dt = std::sqrt(1.0 / config.rate_hz);
  for (std::size_t i = 1; i < count; ++i) {
    biases_[i].gyro = biases_[i - 1].gyro + (config.gyro_bias_walk * root_dt) * random.normal3();
    biases_[i].accel = biases_[i - 1].accel + (config.accel_bias_walk * root_dt) * random.normal3();
  }
}

Duration ImuModel::sample_time(std::int64_t index) const {
  return from_seconds(static_cast<double>(index) / config_.rate_hz);
}

sensor::ImuSample ImuModel::sample(const Motion& motion, std::int64_t index) const {
  const Duration time = sample_time(index);
  sensor::ImuSample sample = ideal_sample(motion.at(to_seconds(time)));
  sample.time = Time(time);
  if (config_.perfect) return sample;
  Random random(sub_seed(sub_seed(seed_, kNoise), static_cast<std::uint64_t>(index)));
  const ImuBias bias = bias_at(time);
  const double root_rate = std::sqrt(config_.rate_hz);
  sample.gyro += bias.gyro + (config_.gyro_noise_density * root_rate) * random.normal3();
  sample.accel += bias.accel + (config_.accel_noise_density * root_rate) * random.normal3();
  return sample;
}

ImuBias ImuModel::bias_at(Duration since_start) const {
  const auto index = static_cast<std::int64_t>(std::floor(to_seconds(since_start) * config_.rate_hz + 1e-6));
  return biases_[static_cast<std::size_t>(
      std::clamp<std::int64_t>(index, 0, static_cast<std::int64_t>(biases_.size()) - 1))];
}

sensor::ImuSample ideal_sample(const Kinematics& kinematics) {
  const math::Vector3d up_pull(0.0, 0.0, kGravity);  // what holds a body still against gravity
  return {Time{}, kinematics.angular_rate_imu,
          kinematics.T_world_imu.R.transpose() * (kinematics.acceleration_world + up_pull)};
}

Fields ImuConfig::fields() {
  return {
      field("rate_hz", rate_hz, "Hz", {10.0, 5000.0}, "samples per second"),
      field("perfect", perfect, "neither noise nor bias"),
      field("gyro_noise_density", gyro_noise_density, "rad/s/sqrt(Hz)", {1e-8, 1.0},
            "white noise of the gyroscope"),
      field("accel_noise_density", accel_noise_density, "m/s^2/sqrt(Hz)", {1e-8, 10.0},
            "white noise of the accelerometer"),
      field("gyro_bias_walk", gyro_bias_walk, "rad/s^2/sqrt(Hz)", {0.0, 1.0},
            "random walk of the gyroscope's bias"),
      field("accel_bias_walk", accel_bias_walk, "m/s^3/sqrt(Hz)", {0.0, 10.0},
            "random walk of the accelerometer's bias"),
      field("gyro_turn_on_bias", gyro_turn_on_bias, "rad/s", {0.0, 1.0},
            "standard deviation of the first bias, per axis"),
      field("accel_turn_on_bias", accel_turn_on_bias, "m/s^2", {0.0, 10.0},
            "standard deviation of the first bias, per axis"),
  };
}

}  // namespace mmlins::sim

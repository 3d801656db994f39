// SPDX-License-Identifier: MIT
#include "mmlins/sim/imu_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/sim/random.hpp"

namespace mmlins::sim {

namespace {

enum RandomPart : std::uint64_t { kBiases, kNoise, kAxes, kVibration, kJitter, kDrops };

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr int kVibrationWaves = 3;
constexpr double kVibrationSpread = 0.3;      // of the frequencies about the middle one, as a share
constexpr double kRocking = 0.02;             // [rad/s] that come with 1 m/s^2 of vibration
constexpr double kLargestJitterShare = 0.45;  // of the sample period: stamps never run backwards

/// What the fields of a class are.
ImuConfig class_values(ImuClass model) {
  ImuConfig config;
  switch (model) {
    case ImuClass::kCustom:
      break;
    case ImuClass::kBmi088:
      config.gyro_noise_density = 2.44e-4;
      config.accel_noise_density = 1.7e-3;
      config.gyro_bias_walk = 2.0e-5;
      config.accel_bias_walk = 2.0e-4;
      config.gyro_turn_on_bias = 3.5e-3;
      config.accel_turn_on_bias = 0.1;
      config.scale_error = 3e-3;
      config.misalignment_deg = 0.15;
      config.gyro_limit = 34.9;
      config.accel_limit = 235.0;
      break;
    case ImuClass::kConsumer:
      config.gyro_noise_density = 5e-4;
      config.accel_noise_density = 3e-3;
      config.gyro_bias_walk = 1e-4;
      config.accel_bias_walk = 1e-3;
      config.gyro_turn_on_bias = 8.7e-3;
      config.accel_turn_on_bias = 0.2;
      config.scale_error = 5e-3;
      config.misalignment_deg = 0.3;
      config.gyro_limit = 8.7;
      config.accel_limit = 78.5;
      break;
    case ImuClass::kTactical:
      config.gyro_noise_density = 4e-5;
      config.accel_noise_density = 1.8e-3;
      config.gyro_bias_walk = 1e-6;
      config.accel_bias_walk = 1e-5;
      config.gyro_turn_on_bias = 2e-5;
      config.accel_turn_on_bias = 0.01;
      config.scale_error = 5e-4;
      config.misalignment_deg = 0.02;
      config.gyro_limit = 8.7;
      config.accel_limit = 98.0;
      break;
  }
  return config;
}

/// Each axis has a scale of its own and is turned a little towards the others.
math::Matrix3d imperfect_axes(double scale_error, double misalignment, Random& random) {
  math::Matrix3d axes = math::Matrix3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      axes(row, column) += (row == column ? scale_error : misalignment) * random.normal();
    }
  }
  return axes;
}

}  // namespace

ImuConfig ImuConfig::resolved() const {
  const ImuConfig usual;
  const ImuConfig of_class = class_values(model);
  ImuConfig result = *this;
  for (double ImuConfig::*member :
       {&ImuConfig::gyro_noise_density, &ImuConfig::accel_noise_density, &ImuConfig::gyro_bias_walk,
        &ImuConfig::accel_bias_walk, &ImuConfig::gyro_turn_on_bias, &ImuConfig::accel_turn_on_bias,
        &ImuConfig::scale_error, &ImuConfig::misalignment_deg, &ImuConfig::gyro_limit,
        &ImuConfig::accel_limit}) {
    if (this->*member == usual.*member) result.*member = of_class.*member;
  }
  return result;
}

ImuModel::ImuModel(const ImuConfig& config, std::uint64_t seed, Duration duration)
    : config_(config.resolved()), seed_(seed) {
  const auto count = static_cast<std::size_t>(std::ceil(to_seconds(duration) * config_.rate_hz)) + 2;
  biases_.resize(count);
  if (config_.perfect) return;
  Random axes(sub_seed(seed, kAxes));
  const double misalignment = config_.misalignment_deg * std::numbers::pi / 180.0;
  gyro_axes_ = imperfect_axes(config_.scale_error, misalignment, axes);
  accel_axes_ = imperfect_axes(config_.scale_error, misalignment, axes);
  Random random(sub_seed(seed, kBiases));
  biases_[0] = {config_.gyro_turn_on_bias * random.normal3(), config_.accel_turn_on_bias * random.normal3()};
  const double root_dt = std::sqrt(1.0 / config_.rate_hz);
  for (std::size_t i = 1; i < count; ++i) {
    biases_[i].gyro = biases_[i - 1].gyro + (config_.gyro_bias_walk * root_dt) * random.normal3();
    biases_[i].accel = biases_[i - 1].accel + (config_.accel_bias_walk * root_dt) * random.normal3();
  }
}

Duration ImuModel::sample_time(std::int64_t index) const {
  return from_seconds(static_cast<double>(index) / config_.rate_hz);
}

bool ImuModel::is_dropped(std::int64_t index) const {
  if (config_.perfect || config_.drop_share <= 0.0) return false;
  return Random(sub_seed(sub_seed(seed_, kDrops), static_cast<std::uint64_t>(index)))
      .chance(config_.drop_share);
}

sensor::ImuSample ImuModel::sample(const Motion& motion, std::int64_t index) const {
  const Duration time = sample_time(index);
  sensor::ImuSample sample = ideal_sample(motion.at(to_seconds(time)));
  sample.time = Time(time);
  if (config_.perfect) return sample;
  sample.time += stamp_error(index);
  add_vibration(sample, to_seconds(time));
  spoil_scale_and_axes(sample);
  Random random(sub_seed(sub_seed(seed_, kNoise), static_cast<std::uint64_t>(index)));
  const ImuBias bias = bias_at(time);
  const double root_rate = std::sqrt(config_.rate_hz);
  sample.gyro += bias.gyro + (config_.gyro_noise_density * root_rate) * random.normal3();
  sample.accel += bias.accel + (config_.accel_noise_density * root_rate) * random.normal3();
  saturate(sample);
  return sample;
}

Duration ImuModel::stamp_error(std::int64_t index) const {
  double error = config_.time_offset;
  if (config_.stamp_jitter > 0.0) {
    const double largest = kLargestJitterShare / config_.rate_hz;
    Random random(sub_seed(sub_seed(seed_, kJitter), static_cast<std::uint64_t>(index)));
    error += std::clamp(config_.stamp_jitter * random.normal(), -largest, largest);
  }
  return from_seconds(error);
}

void ImuModel::spoil_scale_and_axes(sensor::ImuSample& sample) const {
  sample.gyro = gyro_axes_ * sample.gyro;
  sample.accel = accel_axes_ * sample.accel;
}

void ImuModel::add_vibration(sensor::ImuSample& sample, double seconds) const {
  if (config_.vibration <= 0.0) return;
  Random random(sub_seed(seed_, kVibration));  // the same waves for all samples
  const double amplitude = config_.vibration * std::sqrt(2.0 / kVibrationWaves);
  for (int axis = 0; axis < 3; ++axis) {
    for (int wave = 0; wave < kVibrationWaves; ++wave) {
      const double hz = config_.vibration_hz * random.uniform(1.0 - kVibrationSpread, 1.0 + kVibrationSpread);
      const double phase = kTwoPi * (hz * seconds + random.uniform());
      sample.accel[axis] += amplitude * std::sin(phase);
      sample.gyro[axis] += kRocking * amplitude * std::cos(phase);
    }
  }
}

void ImuModel::saturate(sensor::ImuSample& sample) const {
  const auto limited = [](const math::Vector3d& v, double limit) -> math::Vector3d {
    return limit > 0.0 ? v.cwiseMax(-limit).cwiseMin(limit) : v;
  };
  sample.gyro = limited(sample.gyro, config_.gyro_limit);
  sample.accel = limited(sample.accel, config_.accel_limit);
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

std::vector<std::string> imu_names() { return {"custom", "bmi088", "consumer", "tactical"}; }

Fields ImuConfig::fields() {
  return {
      field("model", model, imu_names(),
            "class of the sensor: its values take the place of all that are left at their defaults"),
      field("rate_hz", rate_hz, "Hz", {10.0, 5000.0}, "samples per second"),
      field("perfect", perfect, "nothing but the exact values at exact times"),
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
      field("scale_error", scale_error, "", {0.0, 0.1}, "standard deviation of the scale of an axis"),
      field("misalignment_deg", misalignment_deg, "deg", {0.0, 10.0},
            "standard deviation of the angle between an axis and where it should point"),
      field("gyro_limit", gyro_limit, "rad/s", {0.0, 1000.0}, "largest reading; 0: none"),
      field("accel_limit", accel_limit, "m/s^2", {0.0, 1e4}, "largest reading; 0: none"),
      field("vibration", vibration, "m/s^2", {0.0, 100.0},
            "root mean square of the carrier's vibration, per axis"),
      field("vibration_hz", vibration_hz, "Hz", {1.0, 1000.0}, "about which frequency it vibrates"),
      field("time_offset", time_offset, "s", {-1.0, 1.0}, "added to every stamp: how far the clock is ahead"),
      field("stamp_jitter", stamp_jitter, "s", {0.0, 0.1}, "standard deviation of the stamps"),
      field("drop_share", drop_share, "", {0.0, 0.9}, "share of the samples that never arrive"),
  };
}

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/keyframe_builder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace mmlins::keyframe {
namespace {

using math::SE3;
using math::Vector3d;

}  // namespace

Fields KeyframeConfig::fields() {
  return {
      field("distance", distance, "m", {0.05, 20.0}, "between keyframes"),
      field("angle_deg", angle_deg, "deg", {1.0, 180.0}, "turn after which there is one as well"),
      field("voxel", voxel, "m", {0.05, 2.0}, "one point is kept in each cube of this edge"),
  };
}

KeyframeBuilder::KeyframeBuilder(const KeyframeConfig& config) : config_(config), seen_(config.voxel) {}

std::optional<Keyframe> KeyframeBuilder::add(const PlacedScan& scan) {
  const bool has_intensities = scan.intensities.size() == scan.points_imu.size();
  for (std::size_t i = 0; i < scan.points_imu.size(); ++i) {
    const Vector3d p_map = scan.T_map_imu * scan.points_imu[i].cast<double>();
    const std::size_t num_before = seen_.payloads().size();
    const std::uint32_t cell = seen_.find_or_add(seen_.index_of(p_map));
    if (seen_.payloads().size() == num_before) continue;
    const float intensity = has_intensities ? std::clamp(scan.intensities[i], 0.0F, 65535.0F) : 0.0F;
    seen_.payloads()[cell] = {p_map.cast<float>(), static_cast<std::uint16_t>(std::lround(intensity))};
  }
  latest_ = Keyframe{next_id_, scan.map_id, scan.time, scan.T_map_imu, scan.down_imu, {}, {}};
  if (!is_due(scan)) return std::nullopt;
  T_map_last_ = scan.T_map_imu;
  return take();
}

bool KeyframeBuilder::is_due(const PlacedScan& scan) const {
  if (!T_map_last_) return true;
  return (scan.T_map_imu.t - T_map_last_->t).norm() >= config_.distance ||
         turn_between(*T_map_last_, scan.T_map_imu) >= config_.angle_deg * std::numbers::pi / 180.0;
}

std::optional<Keyframe> KeyframeBuilder::finish() {
  T_map_last_.reset();
  if (!latest_) return std::nullopt;
  return take();
}

Keyframe KeyframeBuilder::take() {
  Keyframe keyframe = std::move(*latest_);
  latest_.reset();
  ++next_id_;
  const SE3 T_imu_map = keyframe.T_map_imu.inverse();
  keyframe.points_imu.reserve(seen_.payloads().size());
  for (const Seen& seen : seen_.payloads()) {
    const Vector3d p_imu = T_imu_map * seen.p_map.cast<double>();
    if (p_imu.cwiseAbs().maxCoeff() > kPointReach) continue;
    const Eigen::Array3d steps = (p_imu.array() / kPointQuantum).round();
    keyframe.points_imu.push_back((steps * kPointQuantum).matrix().cast<float>());
    keyframe.intensities.push_back(seen.intensity);
  }
  seen_ = spatial::VoxelTable<Seen>(config_.voxel);
  return keyframe;
}

}  // namespace mmlins::keyframe

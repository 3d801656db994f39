// SPDX-License-Identifier: MIT
// Writes the folder of a run as large as one likes, for tools/measure_viewer.py: a drive up and down the
// streets of a town of blocks, seen by a scanner of 10 000 points per keyframe. make_large_run DIR
// MILLIONS_OF_POINTS

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/base/text_file.hpp"
#include "mmlins/eval/trajectory_file.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins {
namespace {

using math::SE3;
using math::Vector3d;

constexpr double kPitch = 40.0;  ///< from one house to the next [m]
constexpr double kHalf = 12.0;   ///< half the side of a house [m]
constexpr double kStep = 1.5;    ///< between keyframes [m]
constexpr int kHousesPerRow = 9;
constexpr int kPointsPerKeyframe = 10'000;
constexpr double kRange = 80.0;  ///< [m]
constexpr double kHeight = 1.8;  ///< of the scanner above the street [m]

double height_of_house(int column, int row) { return 6.0 + 3.0 * ((column * 7 + row * 13) % 6); }

/// Distance along a ray to a house; infinite if it misses.
double hit_house(const Vector3d& p, const Vector3d& d, int column, int row) {
  const Vector3d low(kPitch * column - kHalf, kPitch * row - kHalf, 0.0);
  const Vector3d high(kPitch * column + kHalf, kPitch * row + kHalf, height_of_house(column, row));
  double enter = 0.0;
  double leave = kRange;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (low[axis] - p[axis]) / d[axis];
    const double b = (high[axis] - p[axis]) / d[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : kRange;
}

double cast(const Vector3d& p, const Vector3d& d) {
  double range = d.z() < 0.0 ? std::min(kRange, -p.z() / d.z()) : kRange;
  const int column = static_cast<int>(std::lround(p.x() / kPitch));
  const int row = static_cast<int>(std::lround(p.y() / kPitch));
  for (int i = column - 2; i <= column + 2; ++i) {
    for (int j = row - 2; j <= row + 2; ++j) range = std::min(range, hit_house(p, d, i, j));
  }
  return range;
}

/// Along one street after the other, to and fro.
SE3 pose_at(double way) {
  const double length = kPitch * kHousesPerRow;
  const double lap = length + kPitch;
  const int street = static_cast<int>(way / lap);
  const double along = way - lap * street;
  const double x = std::min(along, length);
  const bool is_back = street % 2 == 1;
  const double y = kPitch * (street + 0.5) + std::max(0.0, along - length);
  const double heading = along > length ? M_PI / 2 : is_back ? M_PI : 0.0;
  return {math::so3_exp({0.0, 0.0, heading}), {(is_back ? length - x : x) - 0.5 * kPitch, y, kHeight}};
}

keyframe::Keyframe make_keyframe(int id) {
  keyframe::Keyframe keyframe;
  keyframe.id = id;
  keyframe.time = time_from_ns(1'700'000'000'000'000'000 + 300'000'000LL * id);
  keyframe.T_map_imu = pose_at(kStep * id);
  math::Random random(static_cast<std::uint64_t>(id) + 1);
  while (static_cast<int>(keyframe.points_imu.size()) < kPointsPerKeyframe) {
    const double azimuth = 2.0 * M_PI * random.uniform();
    const double elevation = -0.45 + 0.9 * random.uniform();
    const Vector3d d_imu(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation));
    const double range = cast(keyframe.T_map_imu.t, keyframe.T_map_imu.R * d_imu);
    if (range >= kRange) continue;
    Eigen::Vector3f point;
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] =
          static_cast<float>(static_cast<double>(std::lround(d_imu[axis] * range / keyframe::kPointQuantum)) *
                             keyframe::kPointQuantum);
    }
    keyframe.points_imu.push_back(point);
    keyframe.intensities.push_back(static_cast<std::uint16_t>(20.0 + 200.0 * random.uniform()));
  }
  return keyframe;
}

bool write_run(const std::string& folder, int num_keyframes) {
  auto atlas = atlas::Atlas::create(folder + "/atlas");
  if (!atlas) return false;
  atlas::MapRow map;
  map.state = atlas::MapState::kSleeping;
  map.beginning = "at rest";
  map.begin = make_keyframe(0).time;
  bool ok = atlas->add_map(map).ok();
  math::Trajectory trajectory;
  std::string health = "time,state,cause,map,total_ms\n";
  for (int id = 0; ok && id < num_keyframes; ++id) {
    const keyframe::Keyframe keyframe = make_keyframe(id);
    ok = atlas->add_keyframe(keyframe).ok();
    trajectory.push_back({keyframe.time, keyframe.T_map_imu});
    health += eval::seconds_text(keyframe.time) + ",TRACKING,,0,5.0\n";
    map.last = keyframe.time;
  }
  return ok && atlas->update_map(map).ok() && atlas->commit().ok() &&
         eval::write_tum(folder + "/trajectory.tum", trajectory).ok() &&
         write_text_file(folder + "/health.csv", health).ok() &&
         write_text_file(folder + "/summary.json", "{}").ok();
}

}  // namespace
}  // namespace mmlins

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const double millions = std::atof(argv[2]);
  return mmlins::write_run(argv[1], static_cast<int>(1e6 * millions / mmlins::kPointsPerKeyframe)) ? 0 : 1;
}

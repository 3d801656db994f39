// SPDX-License-Identifier: MIT
#pragma once
// Point clouds in the PCD format, version 0.7: fields x, y, z [m] and intensity.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "mmlins/base/result.hpp"

namespace mmlins::io {

struct PcdCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> intensities;  ///< zeros if the file has none
};

/// Writes binary, under a temporary name that is replaced when the file is complete.
/// @param intensities  one per point, or empty for zeros
[[nodiscard]] Status write_pcd(const std::string& path, std::span<const Eigen::Vector3f> points,
                               std::span<const float> intensities);

/// Reads ASCII and uncompressed binary files with any further fields.
/// Errors name the file and what is wrong with it.
[[nodiscard]] Result<PcdCloud> read_pcd(const std::string& path);

}  // namespace mmlins::io

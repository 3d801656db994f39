// SPDX-License-Identifier: MIT
#pragma once
// Point clouds in the PLY format, as text or little-endian binary.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mmlins/base/result.hpp"

namespace mmlins::io {

/// The places of the element "vertex"; all its other properties, and all other elements, are left out.
/// Errors name the file and what is wrong with it.
[[nodiscard]] Result<std::vector<Eigen::Vector3f>> read_ply(const std::string& path);

}  // namespace mmlins::io

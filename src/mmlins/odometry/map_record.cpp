// SPDX-License-Identifier: MIT
#include "mmlins/odometry/map_record.hpp"

namespace mmlins::odometry {

std::string_view to_string(MapBeginning beginning) {
  switch (beginning) {
    case MapBeginning::kAtRest: return "at rest";
    case MapBeginning::kInMotion: return "in motion";
    case MapBeginning::kAfterGap: return "after a gap";
  }
  return "";
}

}  // namespace mmlins::odometry

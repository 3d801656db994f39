// SPDX-License-Identifier: MIT
#pragma once
// How much of the time a carrier spends on the move: it stands at the start and at stops on the way.

#include <string>
#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/sim/jet.hpp"
#include "mmlins/sim/trajectory_config.hpp"

namespace mmlins::sim {

class TravelClock {
 public:
  /// @param config  resolved
  /// @param stops   all of them, as validate_stops() accepts them
  TravelClock(const TrajectoryConfig& config, std::vector<Stop> stops);

  /// Seconds spent moving until `seconds` of the recording. Its rate is 0 while standing and 1 at full speed.
  [[nodiscard]] Jet at(double seconds) const;

 private:
  [[nodiscard]] Jet without_stops(double seconds) const;

  double stand_still_;  // [s]
  double ramp_;         // [s]
  bool start_in_motion_;
  bool old_start_;
  std::vector<Stop> stops_;
};

/// Whether each stop has the time it takes to slow down and to start again, within a recording of `duration`.
/// @param config  resolved
/// @param source  what to call the recording in the message
[[nodiscard]] Status validate_stops(const TrajectoryConfig& config, std::vector<Stop> stops, double duration,
                                    const std::string& source);

}  // namespace mmlins::sim

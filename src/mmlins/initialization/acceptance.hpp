// SPDX-License-Identifier: MIT
#pragma once
// Whether a start is good enough to begin a map with, and if not, why not: never a start on a guess.
// docs/math/initialization.md, section 5.

#include <string>
#include <string_view>

#include "mmlins/initialization/map_initializer.hpp"

namespace mmlins::initialization {

enum class Verdict {
  kAccepted,
  kTooFewPoses,
  kWindowTooShort,
  kImuGap,
  kNotDetermined,
  kNotConverged,
  kGravityMagnitude,
  kPosesDisagree,
  kPosesNotMeasured,
  kBias,
  kTilt,
  kSpeed,
  kSpeedUnsupported,
};

[[nodiscard]] std::string_view to_string(Verdict verdict);

struct Acceptance {
  Verdict verdict = Verdict::kNotDetermined;
  std::string
      reason;  ///< one line for the user, with the figures; also says with which figures it was accepted

  [[nodiscard]] bool accepted() const { return verdict == Verdict::kAccepted; }
};

/// The tests of the solution, of which the first that fails gives the verdict. `carried` means that the prior
/// knows gravity: then the shorter windows count.
[[nodiscard]] Acceptance judge(const MapSolution& solution, bool carried, const InitializationConfig& config);

struct Initialization {
  MapSolution solution;
  Acceptance acceptance;
};

/// Solves and judges.
[[nodiscard]] Initialization initialize(const Window& window, const StatePrior& prior,
                                        const InitializationConfig& config);

}  // namespace mmlins::initialization

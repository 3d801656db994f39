// SPDX-License-Identifier: MIT
#include "mmlins/mapping/closure.hpp"

#include "mmlins/base/check.hpp"

namespace mmlins::mapping {

std::string_view to_string(ClosureOrigin origin) {
  switch (origin) {
    case ClosureOrigin::kPredicted: return "predicted";
    case ClosureOrigin::kSearched: return "searched";
    case ClosureOrigin::kRecognised: return "recognised";
  }
  MMLINS_CHECK(false);
  return "";
}

std::string_view to_string(ClosureState state) {
  switch (state) {
    case ClosureState::kRefused: return "refused";
    case ClosureState::kWaiting: return "waiting";
    case ClosureState::kConfirmed: return "confirmed";
    case ClosureState::kCounts: return "counts";
    case ClosureState::kRejected: return "rejected";
  }
  MMLINS_CHECK(false);
  return "";
}

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#pragma once
// What can go wrong with a LiDAR for a while: the kinds of events, how they are written down by a user,
// and when they hold.

#include <string>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/base/time.hpp"

namespace mmlins::degrade {

enum class EventKind {
  kBlackout,
  kBag,
  kTornBag,
  kSector,
  kSmoke,
  kThin,
  kThinTo,
  kVoxel,
  kRangeCap,
  kPacketLoss,
  kKidnap,
  kElevator
};

/// What the severity of a kind means, its usual value and the accepted ones.
struct KindInfo {
  EventKind kind;
  std::string word;
  std::string severity_meaning;
  std::string unit;
  double usual = 1.0;
  FieldRange range;
  bool moves_carrier = false;  ///< so that it cannot be applied to a recording, only simulated
};

/// All kinds in the order of the enum.
[[nodiscard]] const std::vector<KindInfo>& event_kinds();
[[nodiscard]] const KindInfo& info_of(EventKind kind);
/// "bag, blackout, ...": those that can be applied to a recording, for messages.
[[nodiscard]] std::string list_of_kinds();

/// One event; it holds for start <= time < start + duration.
struct EventSpec {
  EventKind kind = EventKind::kBlackout;
  double start = 0.0;     ///< after the start of the recording [s]
  double duration = 5.0;  ///< [s]
  double severity = 0.0;  ///< its meaning depends on the kind; 0: the usual value of the kind

  [[nodiscard]] Fields fields();
  /// The severity, or the usual one if none is given.
  [[nodiscard]] double effective_severity() const;
  [[nodiscard]] Duration begin() const { return from_seconds(start); }
  [[nodiscard]] Duration end() const { return from_seconds(start) + from_seconds(duration); }
};

/// Reads "kind:start:duration[:severity]", for a recording. Errors quote the text, and list the kinds if the
/// kind is wrong.
[[nodiscard]] Result<EventSpec> parse_event(const std::string& text);

/// Writes what parse_event reads.
[[nodiscard]] std::string to_text(const EventSpec& event);

/// Severity within the range of the kind, and the whole event within the recording.
/// @param length  of the recording
/// @param source  what to call it in the message
[[nodiscard]] Status validate(const EventSpec& event, Duration length, const std::string& source);

/// The table that goes beside a recording: kind, start, end, severity; absolute seconds with 9 decimals.
[[nodiscard]] std::string events_csv(const std::vector<EventSpec>& events, Time recording_start);

}  // namespace mmlins::degrade

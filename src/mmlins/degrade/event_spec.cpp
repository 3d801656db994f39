// SPDX-License-Identifier: MIT
#include "mmlins/degrade/event_spec.hpp"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace mmlins::degrade {

namespace {

constexpr double kLongest = 1e6;  // [s]

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ':') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

Result<double> number_from(const std::string& part, const std::string& name, const std::string& text) {
  double number = 0.0;
  const char* const end = part.data() + part.size();
  const auto [stop, error] = std::from_chars(part.data(), end, number);
  if (error != std::errc{} || stop != end || !std::isfinite(number)) {
    return make_error(ErrorCode::kInvalid, "event '{}': {} '{}' is not a number", text, name, part);
  }
  return number;
}

std::string with_unit(const std::string& unit) { return unit.empty() ? "" : " " + unit; }

/// Seconds with all nanoseconds, without the rounding of a double.
std::string seconds_text(Time time) {
  const std::int64_t ns = to_ns(time);
  return fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", std::llabs(ns / 1'000'000'000),
                     std::llabs(ns % 1'000'000'000));
}

}  // namespace

const std::vector<KindInfo>& event_kinds() {
  static const std::vector<KindInfo> kinds = {
      {EventKind::kBlackout, "blackout", "without meaning", "", 1.0, {1.0, 1.0}},
      {EventKind::kBag, "bag", "distance of the membrane", "m", 0.6, {0.15, 1.5}},
      {EventKind::kTornBag, "torn_bag", "distance of the membrane", "m", 0.6, {0.15, 1.5}},
      {EventKind::kSector, "sector", "covered share of the horizon", "", 0.5, {0.01, 1.0}},
      {EventKind::kSmoke, "smoke", "extinction", "1/m", 0.3, {0.001, 10.0}},
      {EventKind::kThin, "thin", "share of the points that remains", "", 0.05, {1e-5, 1.0}},
      {EventKind::kThinTo, "thin_to", "points that remain of a scan", "", 100.0, {1.0, 1e6}},
      {EventKind::kVoxel, "voxel", "edge of the voxels", "m", 2.0, {0.01, 100.0}},
      {EventKind::kRangeCap, "range_cap", "farthest range", "m", 5.0, {0.1, 1000.0}},
      {EventKind::kPacketLoss, "packet_loss", "share of the packets that is lost", "", 1.0, {0.01, 1.0}},
      {EventKind::kKidnap, "kidnap", "way along the course", "m", 10.0, {0.1, 1000.0}, true},
      {EventKind::kElevator, "elevator", "rise", "m", 3.2, {-100.0, 100.0}, true},
  };
  return kinds;
}

const KindInfo& info_of(EventKind kind) { return event_kinds()[static_cast<std::size_t>(kind)]; }

std::string list_of_kinds() {
  std::string list;
  for (const KindInfo& info : event_kinds()) {
    if (!info.moves_carrier) list += (list.empty() ? "" : ", ") + info.word;
  }
  return list;
}

double EventSpec::effective_severity() const { return severity != 0.0 ? severity : info_of(kind).usual; }

Fields EventSpec::fields() {
  std::vector<std::string> words;
  for (const KindInfo& info : event_kinds()) words.push_back(info.word);
  return {
      field("kind", kind, words, "what happens"),
      field("start", start, "s", {0.0, kLongest}, "when it begins, after the start of the recording"),
      field("duration", duration, "s", {1e-3, kLongest}, "how long it lasts"),
      field("severity", severity, "", {-1e6, 1e6}, "how bad it is, in the unit of its kind; 0: as usual"),
  };
}

Result<EventSpec> parse_event(const std::string& text) {
  const std::vector<std::string> parts = split(text);
  EventSpec event;
  const KindInfo* found = nullptr;
  for (const KindInfo& info : event_kinds()) {
    if (info.word == parts[0]) found = &info;
  }
  if (found == nullptr) {
    return make_error(ErrorCode::kInvalid, "event '{}': there is no kind '{}'; kinds are {}", text, parts[0],
                      list_of_kinds());
  }
  if (found->moves_carrier) {
    return make_error(
        ErrorCode::kUnsupported,
        "event '{}': {} cannot be applied to a recording, because it moves the sensors; simulate "
        "it (mmlins simulate)",
        text, found->word);
  }
  event.kind = found->kind;
  if (parts.size() < 3 || parts.size() > 4) {
    return make_error(ErrorCode::kInvalid,
                      "event '{}': write it as kind:start:duration[:severity], in seconds", text);
  }
  const auto start = number_from(parts[1], "start", text);
  if (!start) return start.error();
  const auto duration = number_from(parts[2], "duration", text);
  if (!duration) return duration.error();
  event.start = *start;
  event.duration = *duration;
  if (parts.size() == 4) {
    const auto severity = number_from(parts[3], "severity", text);
    if (!severity) return severity.error();
    if (!(*severity > 0.0)) {
      return make_error(ErrorCode::kInvalid, "event '{}': the severity must be greater than 0", text);
    }
    event.severity = *severity;
  }
  return event;
}

std::string to_text(const EventSpec& event) {
  return fmt::format("{}:{}:{}:{}", info_of(event.kind).word, event.start, event.duration,
                     event.effective_severity());
}

Status validate(const EventSpec& event, Duration length, const std::string& source) {
  const KindInfo& info = info_of(event.kind);
  const double severity = event.effective_severity();
  if (info.range.min == info.range.max && severity != info.range.min) {
    return make_error(ErrorCode::kInvalid, "{}: event {}: {} has no severity; leave it out", source, to_text(event), info.word);
  }
  if (!(severity >= info.range.min && severity <= info.range.max)) {
    return make_error(ErrorCode::kInvalid, "{}: event {}: severity ({}) must be {} to {}{}", source,
                      to_text(event), info.severity_meaning, info.range.min, info.range.max,
                      with_unit(info.unit));
  }
  if (!(event.duration >= 1e-3 && event.duration <= kLongest)) {
    return make_error(ErrorCode::kInvalid, "{}: event {}: the duration must be 0.001 to {:.0f} s", source,
                      to_text(event), kLongest);
  }
  if (!(event.start >= 0.0 && event.start <= kLongest) || event.end() > length) {
    return make_error(ErrorCode::kInvalid,
                      "{}: event {} lies outside of the recording, which lasts {:.3f} s; let it begin "
                      "and end within",
                      source, to_text(event), to_seconds(length));
  }
  return {};
}

std::string events_csv(const std::vector<EventSpec>& events, Time recording_start) {
  std::string csv = "kind,start,end,severity\n";
  for (const EventSpec& event : events) {
    csv +=
        fmt::format("{},{},{},{}\n", info_of(event.kind).word, seconds_text(recording_start + event.begin()),
                    seconds_text(recording_start + event.end()), event.effective_severity());
  }
  return csv;
}

}  // namespace mmlins::degrade

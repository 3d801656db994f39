// SPDX-License-Identifier: MIT
#include "mmlins/degrade/event_spec.hpp"

#include <gtest/gtest.h>

namespace mmlins::degrade {
namespace {

std::string error_of(const std::string& text) {
  const auto event = parse_event(text);
  if (event.ok()) return "accepted";
  EXPECT_EQ(event.error().message.find('\n'), std::string::npos) << "one line";
  return event.error().message;
}

TEST(EventSpec, TextIsReadAndAMissingSeverityIsTheUsualOne) {
  const auto bag = parse_event("bag:12.5:4:0.3");
  ASSERT_TRUE(bag.ok());
  EXPECT_EQ(bag->kind, EventKind::kBag);
  EXPECT_EQ(bag->start, 12.5);
  EXPECT_EQ(bag->duration, 4.0);
  EXPECT_EQ(bag->effective_severity(), 0.3);
  const auto smoke = parse_event("smoke:0:1e-1");
  ASSERT_TRUE(smoke.ok());
  EXPECT_EQ(smoke->effective_severity(), info_of(EventKind::kSmoke).usual);
}

TEST(EventSpec, EveryKindReadsBackWhatIsWritten) {
  for (const KindInfo& info : event_kinds()) {
    EXPECT_EQ(info_of(info.kind).word, info.word) << "in the order of the enum";
    if (info.moves_carrier) continue;
    const EventSpec event{info.kind, 0.1, 2.25, 0.0};
    const auto read = parse_event(to_text(event));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(to_text(*read), to_text(event));
    EXPECT_TRUE(validate(*read, from_seconds(10.0), "x").ok()) << "the usual severity is an accepted one";
  }
}

TEST(EventSpec, WrongTextsAreQuotedAndTheKindsListed) {
  EXPECT_EQ(error_of("fog:1:2"), "event 'fog:1:2': there is no kind 'fog'; kinds are " + list_of_kinds());
  EXPECT_EQ(error_of(""), "event '': there is no kind ''; kinds are " + list_of_kinds());
  const std::string form = "write it as kind:start:duration[:severity], in seconds";
  EXPECT_EQ(error_of("bag:1"), "event 'bag:1': " + form);
  EXPECT_EQ(error_of("bag:1:2:3:4"), "event 'bag:1:2:3:4': " + form);
  EXPECT_EQ(error_of("bag:x:2"), "event 'bag:x:2': start 'x' is not a number");
  EXPECT_EQ(error_of("bag:1:"), "event 'bag:1:': duration '' is not a number");
  EXPECT_EQ(error_of("bag:1:2s"), "event 'bag:1:2s': duration '2s' is not a number");
  EXPECT_EQ(error_of("bag:1:nan"), "event 'bag:1:nan': duration 'nan' is not a number");
  EXPECT_EQ(error_of("bag:1:2:0"), "event 'bag:1:2:0': the severity must be greater than 0");
}

TEST(EventSpec, WhatMovesTheCarrierIsRefusedForRecordings) {
  for (const std::string kind : {"kidnap", "elevator"}) {
    const std::string text = kind + ":1:5:3";
    EXPECT_EQ(error_of(text),
              "event '" + text + "': " + kind +
                  " cannot be applied to a recording, because it moves the sensors; simulate it "
                  "(mmlins simulate)");
    EXPECT_EQ(list_of_kinds().find(kind), std::string::npos);
  }
}

TEST(EventSpec, AnElevatorMayGoDown) {
  const EventSpec down{EventKind::kElevator, 1.0, 8.0, -3.0};
  EXPECT_EQ(down.effective_severity(), -3.0);
  EXPECT_TRUE(validate(down, from_seconds(20.0), "x").ok());
  EXPECT_FALSE(validate({EventKind::kKidnap, 1.0, 8.0, -3.0}, from_seconds(20.0), "x").ok());
}

TEST(EventSpec, EventsOutsideOfTheRecordingAreRefused) {
  const auto error = [](double start, double duration, double severity) {
    const Status status = validate({EventKind::kBag, start, duration, severity}, from_seconds(20.0), "a.bag");
    return status.ok() ? "accepted" : status.error().message;
  };
  EXPECT_EQ(error(15.0, 5.0, 0.0), "accepted");
  EXPECT_EQ(error(15.0, 5.001, 0.0),
            "a.bag: event bag:15:5.001:0.6 lies outside of the recording, which lasts 20.000 s; let it begin "
            "and end "
            "within");
  EXPECT_EQ(
      error(-1.0, 2.0, 0.5),
      "a.bag: event bag:-1:2:0.5 lies outside of the recording, which lasts 20.000 s; let it begin and end "
      "within");
  EXPECT_EQ(error(1.0, 0.0, 0.5), "a.bag: event bag:1:0:0.5: the duration must be 0.001 to 1000000 s");
  EXPECT_EQ(error(1.0, 1e300, 0.5), "a.bag: event bag:1:1e+300:0.5: the duration must be 0.001 to 1000000 s");
  EXPECT_EQ(error(1.0, 2.0, 3.0),
            "a.bag: event bag:1:2:3: severity (distance of the membrane) must be 0.15 to 1.5 m");
}

TEST(EventSpec, TableHasAbsoluteNanoseconds) {
  const Time start = time_from_ns(1'700'000'000'000'000'001);
  EXPECT_EQ(events_csv({{EventKind::kThinTo, 1.5, 0.25, 50.0}, {EventKind::kBlackout, 2.0, 1.0, 0.0}}, start),
            "kind,start,end,severity\n"
            "thin_to,1700000001.500000001,1700000001.750000001,50\n"
            "blackout,1700000002.000000001,1700000003.000000001,1\n");
}

}  // namespace
}  // namespace mmlins::degrade

// SPDX-License-Identifier: MIT
#include "mmlins/mapping/mapping_config.hpp"

namespace mmlins::mapping {

Fields LinkConfig::fields() {
  return {
      field("position", position, "m", {1e-5, 1.0}, "standard deviation of each link between keyframes"),
      field("position_per_m", position_per_m, "", {0.0, 1.0}, "and of each metre of it"),
      field("rotation_deg", rotation_deg, "deg", {1e-5, 10.0}, "standard deviation of each link"),
      field("rotation_deg_per_m", rotation_deg_per_m, "deg/m", {0.0, 10.0}, "and of each metre of it"),
      field("weak_length", weak_length, "m", {0.1, 1000.0}, "way over which the filter's own deviation is lost once"),
      field("gap_factor", gap_factor, "", {1.0, 100.0}, "by which the deviation of a gap is multiplied"),
      field("gravity_deg", gravity_deg, "deg", {0.01, 90.0}, "standard deviation of the direction of gravity at a keyframe"),
      field("gravity_every", gravity_every, "", {0.0, 10000.0},
            "keyframes that share one measurement of gravity; 0: there are none"),
  };
}

Fields LoopConfig::fields() {
  return {
      field("min_travel", min_travel, "m", {1.0, 10000.0}, "way after which a place of the same map may be met again"),
      field("near", near, "m", {0.0, 100.0}, "between submaps that can overlap well"),
      field("near_between_maps", near_between_maps, "m", {0.0, 100.0},
            "the same of maps that are not joined yet: little is enough, if it comes early"),
      field("search", search, "m", {0.0, 100.0}, "radius of the search around a predicted place, at most"),
      field("direct", direct, "m", {0.0, 10.0}, "standard deviation of a prediction that needs no search"),
      field("direct_deg", direct_deg, "deg", {0.0, 45.0}, "the same of its heading"),
      field("num_predicted", num_predicted, "", {0.0, 100.0}, "places that are tried because they should be near"),
      field("num_recognised", num_recognised, "", {0.0, 100.0}, "places that are tried because they look alike"),
      field("min_score", min_score, "", {0.0, 1.0}, "likeness below which they are not"),
      field("pause", pause, "m", {0.0, 10000.0}, "way after a closure before the next is sought within a map"),
      field("confirmed_within", confirmed_within, "m", {0.0, 10.0},
            "a closure this near to what was known confirms it and changes nothing"),
      field("confirmed_within_deg", confirmed_within_deg, "deg", {0.0, 45.0}, "the same of its rotation"),
  };
}

Fields MergeConfig::fields() {
  return {
      field("num_agreeing", num_agreeing, "", {1.0, 30.0}, "closures between two maps that must agree"),
      field("num_agreeing_with_prior", num_agreeing_with_prior, "", {1.0, 30.0},
            "the same where the IMU carried the pose from one to the other"),
      field("min_span", min_span, "m", {0.0, 1000.0}, "way over which they must be spread"),
      field("min_span_with_prior", min_span_with_prior, "m", {0.0, 1000.0},
            "the same where the IMU carried the pose from one to the other"),
      field("agree_within", agree_within, "m", {0.0, 10.0}, "difference that two closures may have"),
      field("agree_within_per_m", agree_within_per_m, "", {0.0, 1.0}, "and for each metre of way between them"),
      field("agree_within_deg", agree_within_deg, "deg", {0.0, 45.0}, "difference of their headings"),
      field("agree_within_deg_per_m", agree_within_deg_per_m, "deg/m", {0.0, 10.0}, "and for each metre of way"),
      field("num_enhancing", num_enhancing, "", {0.0, 1000.0}, "closures that are added once two maps are joined, at most"),
  };
}

Fields RebuildConfig::fields() {
  return {
      field("enabled", enabled,
            "after a merge or a closure the odometry goes on with a local map rebuilt from the keyframes around it"),
      field("after", after, "", {1.0, 64.0},
            "keyframes after which it takes up what a keyframe has brought; the run waits for the back end if it is later"),
      field("near", near, "m", {5.0, 300.0}, "keyframes farther from the robot are left out"),
      field("recent", recent, "m", {5.0, 1000.0}, "way back over which the local map is taken to be right"),
      field("held_within", held_within, "m", {0.0, 300.0},
            "and it still holds places that the robot has been no farther from than this"),
      field("moved", moved, "m", {0.0, 10.0}, "unless they have been moved by more than this"),
      field("kept_within", kept_within, "m", {0.0, 10.0},
            "the world stays where it was laid under the active map while the robot is this near to where that has it"),
      field("kept_within_deg", kept_within_deg, "deg", {0.0, 45.0}, "the same of its rotation"),
      field("pause", pause, "m", {0.0, 10000.0}, "way after one rebuilt map before the next is made"),
      field("min_known", min_known, "", {1.0, 1000.0}, "keyframes that it does not hold, for it to be rebuilt"),
      field("max_keyframes", max_keyframes, "", {5.0, 10000.0}, "of which it is made at most, of either kind"),
  };
}

Fields MappingConfig::fields() {
  return {
      field("enabled", enabled, "recognise places, close loops and join maps; otherwise odometry alone"),
      field("memory_mb", memory_mb, "MB", {0.0, 1e6},
            "of keyframes kept in memory; older ones are read from the atlas when they are needed. The result is the same"),
      field("fusion", fusion, {"default", "paper", "single", "off"},
            "how maps are joined: by default, as in the MM-LINS paper, with one of its constraints, or not at all"),
      group("keyframe", keyframe, "what the odometry hands on"),
      group("submap", submap, "the unit in which places are recognised"),
      group("place", place, "what a place looks like"),
      group("verification", verification, "when it is the same place"),
      group("search", search, "search around a predicted place"),
      group("optimizer", optimizer, "optimisation of the pose graph"),
      group("link", link, "what the odometry is believed between keyframes"),
      group("loop", loop, "where known places are looked for"),
      group("merge", merge, "what it takes to join two maps"),
      group("rebuild", rebuild, "what goes back to the odometry"),
      group("paper", paper, "the back end after the MM-LINS paper (fusion: paper or single)"),
  };
}

}  // namespace mmlins::mapping

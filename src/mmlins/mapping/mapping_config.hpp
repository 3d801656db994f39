// SPDX-License-Identifier: MIT
#pragma once
// All parameters of the back end, and their only defaults.

#include "mmlins/base/config_fields.hpp"
#include "mmlins/graph/optimize.hpp"
#include "mmlins/keyframe/keyframe_builder.hpp"
#include "mmlins/keyframe/submap.hpp"
#include "mmlins/mapping/paper_config.hpp"
#include "mmlins/place/place_descriptor.hpp"
#include "mmlins/registration/search_around.hpp"
#include "mmlins/registration/verify.hpp"

namespace mmlins::mapping {

/// What the odometry is believed from one keyframe to the next. docs/math/mapping.md, Eq. (1).
struct LinkConfig {
  double position = 0.005;
  double position_per_m = 0.002;
  double rotation_deg = 0.01;
  double rotation_deg_per_m = 0.005;
  double weak_length = 10.0;
  double gap_factor = 2.0;
  double gravity_deg = 0.5;
  int gravity_every = 50;

  [[nodiscard]] Fields fields();
};

/// Where known places are looked for.
struct LoopConfig {
  double min_travel = 30.0;
  double near = 8.0;
  double near_between_maps = 20.0;
  double search = 30.0;
  double direct = 1.0;
  double direct_deg = 4.0;
  int num_predicted = 2;
  int num_recognised = 3;
  double min_score = 0.3;
  double pause = 15.0;
  double confirmed_within = 0.05;
  double confirmed_within_deg = 0.2;

  [[nodiscard]] Fields fields();
};

/// What it takes to join two maps.
struct MergeConfig {
  int num_agreeing = 3;
  int num_agreeing_with_prior = 2;
  double min_span = 5.0;
  double min_span_with_prior = 1.5;
  double agree_within = 0.1;
  double agree_within_per_m = 0.01;
  double agree_within_deg = 0.5;
  double agree_within_deg_per_m = 0.02;
  int num_enhancing = 10;

  [[nodiscard]] Fields fields();
};

/// What goes back to the odometry once places were recognised.
struct RebuildConfig {
  bool enabled = false;
  int after = 8;
  double near = 50.0;
  double recent = 50.0;
  double held_within = 30.0;
  double moved = 0.05;
  double kept_within = 0.05;
  double kept_within_deg = 0.2;
  double pause = 15.0;
  int min_known = 5;
  int max_keyframes = 150;

  [[nodiscard]] Fields fields();
};

/// How maps become one: as this project does it; as the MM-LINS paper does it; the same with a single similarity
/// constraint; not at all.
enum class FusionKind { kDefault, kPaper, kSingle, kOff };

struct MappingConfig {
  bool enabled = true;
  int memory_mb = 128;
  FusionKind fusion = FusionKind::kDefault;
  keyframe::KeyframeConfig keyframe;
  keyframe::SubmapConfig submap;
  place::PlaceConfig place;
  registration::VerificationConfig verification;
  registration::SearchConfig search;
  graph::OptimizerConfig optimizer;
  LinkConfig link;
  LoopConfig loop;
  MergeConfig merge;
  RebuildConfig rebuild;
  PaperFusionConfig paper;

  [[nodiscard]] Fields fields();
};

}  // namespace mmlins::mapping

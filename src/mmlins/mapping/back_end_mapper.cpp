// SPDX-License-Identifier: MIT
#include "mmlins/mapping/back_end_mapper.hpp"

#include "mmlins/mapping/mapper.hpp"
#include "mmlins/mapping/paper_mapper.hpp"

namespace mmlins::mapping {

std::unique_ptr<BackEndMapper> make_mapper(const MappingConfig& config, keyframe::KeyframeStore& store) {
  const bool is_paper = config.fusion == FusionKind::kPaper || config.fusion == FusionKind::kSingle;
  if (config.enabled && is_paper) return std::make_unique<PaperMapper>(config, store);
  return std::make_unique<Mapper>(config, store);
}

}  // namespace mmlins::mapping

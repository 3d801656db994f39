// SPDX-License-Identifier: MIT
#include "mmlins/mapping/back_end_mapper.hpp"

#include "mmlins/mapping/mapper.hpp"

namespace mmlins::mapping {

std::unique_ptr<BackEndMapper> make_mapper(const MappingConfig& config, keyframe::KeyframeStore& store) {
  return std::make_unique<Mapper>(config, store);
}

}  // namespace mmlins::mapping

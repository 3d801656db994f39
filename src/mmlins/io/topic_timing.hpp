// SPDX-License-Identifier: MIT
#pragma once
// How regularly the messages of a topic come.

#include <vector>

#include "mmlins/io/recording_info.hpp"

namespace mmlins::io {

/// @param times  in the order of recording
[[nodiscard]] TopicTiming measure_timing(const std::vector<Time>& times, bool by_stamp);

}  // namespace mmlins::io

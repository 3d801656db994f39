// SPDX-License-Identifier: MIT
#pragma once
// The project's random numbers under the names of this layer.

#include "mmlins/math/random.hpp"

namespace mmlins::sim {

using math::Random;
using math::scramble;
using math::sub_seed;

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#pragma once
// A keyframe as the bytes of a record, and back, bit for bit. Internal to atlas/.

#include "mmlins/atlas/bytes.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/keyframe/keyframe.hpp"

namespace mmlins::atlas {

/// @return an error if a point is no whole multiple of kPointQuantum within reach, or if there are
/// intensities
///   but not one per point
[[nodiscard]] Result<Bytes> encode_keyframe(const keyframe::Keyframe& keyframe);

/// Nothing if the bytes are no keyframe.
[[nodiscard]] std::optional<keyframe::Keyframe> decode_keyframe(ByteView bytes);

}  // namespace mmlins::atlas

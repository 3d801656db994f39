// SPDX-License-Identifier: MIT
#pragma once
// For the files of this folder only: it includes the bag library.

#include <rosbag/bag.h>

#include <memory>

namespace mmlins::io {

/// Not opened yet. What the library does to the home of the user and to standard error on the way is kept away from them.
std::unique_ptr<rosbag::Bag> make_bag();

}  // namespace mmlins::io

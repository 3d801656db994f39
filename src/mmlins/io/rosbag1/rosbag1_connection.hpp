// SPDX-License-Identifier: MIT
#pragma once
// What a bag records about its messages besides their bytes.

#include <map>
#include <string>

namespace mmlins::io {

/// What a bag records about the type of a topic.
struct MessageType {
  std::string name;
  std::string md5sum;
  std::string definition;
};

/// One publisher of one topic, as a bag knows it.
struct BagConnection {
  std::string topic;
  MessageType type;
  std::map<std::string, std::string> header;  ///< as sent by the publisher: its name, whether it latches, ...
};

}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#include "mmlins/io/rosbag1/make_bag.hpp"

#include <console_bridge/console.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace mmlins::io {
namespace {

/// A bag looks for plugins that decrypt, and what was seen on the way is noted in ROS_HOME, or else in the user's home, with
/// complaints if that cannot be written. While this lives ROS_HOME is a folder for that alone, unless the user has set one.
class OwnRosHome {
 public:
  OwnRosHome() {
    if (std::getenv("ROS_HOME") != nullptr) return;
    std::error_code failure;
    std::string folder = (std::filesystem::temp_directory_path(failure) / "mmlins-XXXXXX").string();
    if (failure || mkdtemp(folder.data()) == nullptr) return;
    setenv("ROS_HOME", folder.c_str(), 1);
    folder_ = folder;
  }
  OwnRosHome(const OwnRosHome&) = delete;
  OwnRosHome& operator=(const OwnRosHome&) = delete;
  ~OwnRosHome() {
    if (folder_.empty()) return;
    unsetenv("ROS_HOME");
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

 private:
  std::string folder_;  ///< empty: there is none
};

}  // namespace

std::unique_ptr<rosbag::Bag> make_bag() {
  console_bridge::noOutputHandler();  // the library would print each error a second time
  const OwnRosHome home;
  return std::make_unique<rosbag::Bag>();
}

}  // namespace mmlins::io

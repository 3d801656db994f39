// SPDX-License-Identifier: MIT
#pragma once
// A recording as a stream of measurements in SI units, whatever its topics, fields and units are.

#include <memory>
#include <string>

#include "mmlins/base/result.hpp"
#include "mmlins/io/recording_info.hpp"
#include "mmlins/sensor/dataset.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::io {

struct OpenedDataset {
  std::unique_ptr<sensor::Dataset> dataset;
  RecordingInfo info;  ///< timing of the topics by record time
};

/// Opens a ROS 1 bag. Topics, fields and units that the rig does not give are found out from the first
/// messages.
///
/// The dataset gives ImuSamples [rad/s, m/s^2] and LidarScans in the order of recording, stamps as they
/// are: duplicates and jumps are passed on. Invalid points are dropped and counted; an empty cloud is an
/// empty scan; a message that cannot be decoded is skipped with one warning per topic.
///
/// Errors: the file cannot be read; no topic, or several, of a sensor to choose from; the rig names a
/// topic or a field that does not exist.
[[nodiscard]] Result<OpenedDataset> open_dataset(const std::string& path, const sensor::Rig& rig);

/// What is in a recording, without using it: reads all messages of the sensors for their stamps.
/// That the recording cannot be used (RecordingInfo::problems) is no error here.
[[nodiscard]] Result<RecordingInfo> inspect_recording(const std::string& path, const sensor::Rig& rig);

}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <unordered_set>

#include "mmlins/atlas/export.hpp"
#include "mmlins/base/text_file.hpp"
#include "mmlins/math/grid.hpp"

namespace mmlins::atlas {
namespace {

using math::CellIndex;
using PointRecord = std::array<float, 4>;  // x, y, z, intensity

constexpr std::size_t kHeaderSize = 320;  ///< of both formats; filled up by a comment

/// The header of the file; the number of points is known only at its end, so that all headers have one
/// length.
std::string header_text(CloudFormat format, std::size_t num_points) {
  const bool is_pcd = format == CloudFormat::kPcd;
  std::string before =
      is_pcd ? "# .PCD v0.7 - Point Cloud Data file format\n" : "ply\nformat binary_little_endian 1.0\n";
  const std::string after =
      is_pcd ? fmt::format(
                   "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
                   "WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
                   num_points)
             : fmt::format(
                   "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
                   "property float intensity\nend_header\n",
                   num_points);
  before += is_pcd ? "#" : "comment";
  const std::size_t used = before.size() + after.size() + 1;
  MMLINS_CHECK(used <= kHeaderSize);
  return before + std::string(kHeaderSize - used, ' ') + "\n" + after;
}

/// A file that gets its name when it is complete, and is removed if it never is.
class CloudFile {
 public:
  CloudFile(std::string path, CloudFormat format)
      : path_(std::move(path)), format_(format), file_(std::fopen(part().c_str(), "wb")) {
    if (file_ == nullptr) {
      reason_ = errno;
    } else {
      write(header_text(format_, 0).data(), kHeaderSize);
    }
  }
  CloudFile(const CloudFile&) = delete;
  CloudFile& operator=(const CloudFile&) = delete;
  ~CloudFile() {
    if (file_ == nullptr) return;
    std::fclose(file_);
    std::remove(part().c_str());
  }

  void add(const PointRecord& point) {
    write(point.data(), sizeof(point));
    ++num_points_;
  }
  [[nodiscard]] std::size_t num_points() const { return num_points_; }
  [[nodiscard]] Status status() const {
    if (reason_ == 0) return {};
    return cannot_write(path_, reason_);
  }
  [[nodiscard]] Status finish() {
    if (file_ != nullptr) std::rewind(file_);
    write(header_text(format_, num_points_).data(), kHeaderSize);
    if (file_ != nullptr && std::fclose(std::exchange(file_, nullptr)) != 0) note_failure();
    if (reason_ == 0 && std::rename(part().c_str(), path_.c_str()) != 0) note_failure();
    if (reason_ != 0) std::remove(part().c_str());
    return status();
  }

 private:
  [[nodiscard]] std::string part() const { return path_ + ".part"; }
  void note_failure() {
    if (reason_ == 0) reason_ = errno != 0 ? errno : EIO;
  }
  void write(const void* bytes, std::size_t size) {
    if (file_ != nullptr && reason_ == 0 && std::fwrite(bytes, 1, size, file_) != size) note_failure();
  }

  std::string path_;
  CloudFormat format_;
  std::size_t num_points_ = 0;
  int reason_ = 0;
  std::FILE* file_;
};

/// Which cells hold a point already. Kept in slabs along x, so that those left behind can be forgotten.
class Cells {
 public:
  explicit Cells(double edge) : edge_(edge) {}

  /// @return whether the point is the first one in its cell
  bool add(const Vector3d& p) {
    if (edge_ <= 0.0) return true;
    const CellIndex cell = math::cell_at<double>(p, 1.0 / edge_);
    return slabs_[cell.x() / kCellsPerSlab].insert(math::cell_key(cell)).second;
  }
  void forget_below(double x) {
    if (edge_ <= 0.0) return;
    const int first = static_cast<int>(std::floor(x / edge_)) / kCellsPerSlab;
    slabs_.erase(slabs_.begin(), slabs_.lower_bound(first));
  }

 private:
  static constexpr int kCellsPerSlab = 100;

  double edge_;
  std::map<int, std::unordered_set<std::uint64_t>> slabs_;
};

void add_points(const keyframe::Keyframe& kf, const SE3& T_world_imu, Cells& cells, CloudFile& file) {
  for (std::size_t i = 0; i < kf.points_imu.size(); ++i) {
    const Vector3d p_world = T_world_imu * kf.points_imu[i].cast<double>();
    if (!cells.add(p_world)) continue;
    const Eigen::Vector3f p = p_world.cast<float>();
    file.add({p.x(), p.y(), p.z(), kf.intensities.empty() ? 0.0F : static_cast<float>(kf.intensities[i])});
  }
}

}  // namespace

Result<CloudReport> export_cloud(const Atlas& atlas, std::span<const int> map_ids, const std::string& path,
                                 const CloudOptions& options) {
  auto keyframes = world_keyframes(atlas, map_ids);
  if (!keyframes) return keyframes.error();
  std::stable_sort(keyframes->begin(), keyframes->end(), [](const WorldKeyframe& a, const WorldKeyframe& b) {
    return a.T_world_imu.t.x() < b.T_world_imu.t.x();
  });
  const double reach = std::sqrt(3.0) * (keyframe::kPointReach + 1.0);
  CloudReport report;
  Cells cells(options.voxel);
  CloudFile file(path, options.format);
  for (const WorldKeyframe& placed : *keyframes) {
    if (!file.status()) break;
    const auto kf = atlas.load_keyframe(placed.id);
    if (!kf && report.num_lost++ == 0) report.first_loss = kf.error().message;
    if (!kf) continue;
    cells.forget_below(placed.T_world_imu.t.x() - reach);
    add_points(*kf, placed.T_world_imu, cells, file);
    ++report.num_keyframes;
  }
  report.num_points = file.num_points();
  if (const Status status = file.finish(); !status) return status.error();
  return report;
}

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
#pragma once
// The maps on disk: an index in SQLite and the points in chunk files beside it. Whatever was committed
// survives a killed process, and each change of the graph is there as a whole or not at all. docs/formats.md,
// "Atlas".

#include <memory>
#include <string>
#include <vector>

#include "mmlins/atlas/rows.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/keyframe/keyframe.hpp"

namespace mmlins::atlas {

class ChunkWriter;
class Database;
class FileHandle;

struct AtlasOptions {
  int batch_keyframes = 20;                 ///< as many may be lost with the process at most
  std::int64_t chunk_bytes = 64 * 1000000;  ///< a chunk file does not get larger, but for one single record
};

enum class Access { kRead, kWrite };

/// What a change was given: the ids of the new merges and of the new edges, in their order.
struct Committed {
  std::vector<int> merge_ids;
  std::vector<std::int64_t> edge_ids;
};

/// What was taken out of the atlas.
struct Removed {
  std::size_t num_keyframes = 0;
  std::size_t num_edges = 0;
  std::size_t num_places = 0;
  std::size_t num_merges = 0;
  std::int64_t freed_bytes = 0;  ///< of chunk files that held nothing else
};

/// What is there and what is wrong with it.
struct CheckReport {
  std::size_t num_maps = 0;
  std::size_t num_keyframes = 0;
  std::size_t num_edges = 0;
  std::size_t num_points = 0;         ///< that can be read
  std::vector<std::string> problems;  ///< a line each; empty: all is well
};

/// For one thread at a time. Small writes are gathered in a batch; reads see it at once, others when it is
/// committed. Rows that turn out to be damaged are left out by the reading functions, with one warning.
class Atlas {
 public:
  /// An empty atlas. An older one at that place is replaced; a folder with anything else in it is refused.
  [[nodiscard]] static Result<Atlas> create(const std::string& folder, const AtlasOptions& options = {});
  /// Moves an atlas that nobody is writing, to where nothing is yet; a folder that does not exist is left alone. What is no
  /// atlas is refused.
  [[nodiscard]] static Status move(const std::string& folder, const std::string& to);
  /// For writing: one process at a time, and a map that its process left active falls asleep.
  /// @return an error of code kInvalid if the index is missing or damaged, but salvage() may help
  [[nodiscard]] static Result<Atlas> open(const std::string& folder, Access access,
                                          const AtlasOptions& options = {});
  /// For reading, with an index made in memory from the chunk files and what can still be read of the old
  /// index.
  [[nodiscard]] static Result<Atlas> salvage(const std::string& folder);
  /// For reading in another thread of the process that writes it: what was committed is seen there.
  [[nodiscard]] static Result<Atlas> reader(const std::string& folder);
  [[nodiscard]] Result<Atlas> reader() const { return reader(folder_); }
  Atlas(Atlas&& other) noexcept;
  Atlas& operator=(Atlas&& other) = delete;
  /// Commits; better do so before, where an error can be told.
  ~Atlas();

  [[nodiscard]] const std::string& folder() const { return folder_; }

  [[nodiscard]] Status add_map(const MapRow& map);
  /// Replaces all but the id.
  [[nodiscard]] Status update_map(const MapRow& map);
  /// Its points must be whole multiples of keyframe::kPointQuantum; its ids new.
  [[nodiscard]] Status add_keyframe(const keyframe::Keyframe& keyframe);
  /// The same, where it is known already that an optimisation has moved the map within itself.
  [[nodiscard]] Status add_keyframe(const keyframe::Keyframe& keyframe, const SE3& T_map_imu_optimised);
  /// @return its id
  [[nodiscard]] Result<std::int64_t> add_edge(const EdgeRow& edge);
  [[nodiscard]] Status set_edge_weight(const EdgeWeight& weight);
  [[nodiscard]] Status add_gravity(const GravityRow& gravity);
  [[nodiscard]] Status add_place(const PlaceRow& place);
  /// Ends the batch. To be called as often as little may be lost, as this layer reads no clock; after
  /// AtlasOptions::batch_keyframes keyframes it happens by itself.
  [[nodiscard]] Status commit();

  /// Commits the batch, and then the change in a transaction of its own: all of it or nothing.
  [[nodiscard]] Result<Committed> apply(const GraphChange& change);
  /// A map with all that refers to it. Space in chunk files that hold points of other maps too is not given
  /// back.
  [[nodiscard]] Result<Removed> delete_map(int map_id);

  /// All in the order of their ids.
  [[nodiscard]] Result<std::vector<MapRow>> maps() const;
  [[nodiscard]] Result<std::vector<KeyframeRow>> keyframes() const;
  [[nodiscard]] Result<std::vector<KeyframeRow>> keyframes_of(int map_id) const;
  [[nodiscard]] Result<std::vector<EdgeRow>> edges() const;
  [[nodiscard]] Result<std::vector<GravityRow>> gravity() const;
  [[nodiscard]] Result<std::vector<PlaceRow>> places() const;
  [[nodiscard]] Result<std::vector<MergeRow>> merges() const;
  /// As it was added, bit for bit.
  [[nodiscard]] Result<keyframe::Keyframe> load_keyframe(int id) const;

  /// Reads everything.
  [[nodiscard]] Result<CheckReport> check() const;

 private:
  Atlas(std::string folder, std::unique_ptr<Database> database, const AtlasOptions& options);

  [[nodiscard]] Status become_writer();
  [[nodiscard]] Status begin_batch();
  [[nodiscard]] Result<RecordPlace> append_points(const keyframe::Keyframe& keyframe);
  [[nodiscard]] Status write_merges(const GraphChange& change, Committed& committed);
  [[nodiscard]] Status write_poses(const GraphChange& change);
  [[nodiscard]] Result<std::int64_t> insert_edge(const EdgeRow& edge);
  [[nodiscard]] Result<std::int64_t> remove_unused_chunks();
  void check_points(CheckReport& report) const;
  [[nodiscard]] Status check_references(CheckReport& report) const;

  std::string folder_;
  AtlasOptions options_;
  std::unique_ptr<FileHandle> lock_;  ///< held while writing
  std::unique_ptr<Database> database_;
  std::unique_ptr<ChunkWriter> writer_;
  bool has_batch_ = false;
  int num_pending_ = 0;  ///< keyframes in the batch
};

/// DIR/atlas if there is one, else DIR: commands take the folder of a run as well as that of its atlas.
[[nodiscard]] std::string find_atlas(const std::string& folder);

}  // namespace mmlins::atlas

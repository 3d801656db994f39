// SPDX-License-Identifier: MIT
#pragma once
// All places seen so far, of whichever map. A query returns the ones that look like it, best first, with the
// pose that makes them look most alike. Candidates only: whether it is the same place is for registration to
// say.

#include <functional>
#include <vector>

#include "mmlins/math/se3.hpp"
#include "mmlins/place/place_descriptor.hpp"

namespace mmlins::place {

struct PlaceId {
  int map_id = 0;
  int submap_id = 0;

  auto operator<=>(const PlaceId&) const = default;
};

struct Candidate {
  PlaceId id;
  double score = 0.0;       ///< correlation of the two views, up to 1
  math::SE3 T_place_query;  ///< level: x, y and yaw from the views, z from the grounds
};

/// Which places may answer; for instance none that were seen a moment ago.
using IsEligible = std::function<bool(const PlaceId&)>;

class PlaceDatabase {
 public:
  explicit PlaceDatabase(const PlaceConfig& config);

  void add(const PlaceId& id, PlaceDescriptor descriptor);
  /// Removes all places of a map, or nothing if it has none.
  void remove_map(int map_id);
  [[nodiscard]] std::size_t size() const { return places_.size(); }

  /// At most `max_candidates`, best first; places of equal score in the order of their ids.
  [[nodiscard]] std::vector<Candidate> query(const PlaceDescriptor& query, std::size_t max_candidates,
                                             const IsEligible& is_eligible) const;

 private:
  struct Place {
    PlaceId id;
    PlaceDescriptor descriptor;
  };
  /// The places with the nearest keys.
  [[nodiscard]] std::vector<const Place*> shortlist(const PlaceDescriptor& query,
                                                    const IsEligible& is_eligible) const;

  PlaceConfig config_;
  std::vector<Place> places_;
};

/// How one place lies to another if they are the same: the best of all headings that the spectra allow.
[[nodiscard]] Candidate compare(const PlaceDescriptor& query, const PlaceDescriptor& place,
                                const PlaceConfig& config);

}  // namespace mmlins::place

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"
#include "core/sensor/record.h"
#include "storage/call_context.h"
#include "storage/map_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// What a map showed of a place. The numbers are in the database: never reuse one.
enum class EvidenceKind : std::int16_t { kFrontImage = 1, kRearImage = 2, kCloud = 3 };

struct Evidence {
  LinkPointId link_point;
  MapId map;  // of the anchor that it belongs to
  EvidenceKind kind = EvidenceKind::kFrontImage;
  std::int16_t encoding = 0;  // ImageEncoding or CloudEncoding, by `kind`
  sensor::BlobRef content;
  TimeNs time = 0;  // when it was recorded
  // Where the robot was in `map` then; unset: not known, as near to the place as anybody knows.
  std::optional<Pose2> T_map_robot = {};
};

struct StoredLinkPoint {
  SiteId site;
  graph::LinkPoint point;                  // `graph_version` is set by the store
  std::optional<Environment> environment;  // unset: not known
  bool forced = false;                     // may stand beside one that joins the same maps at the same place
  // Set by the store.
  std::optional<PoseWithCovariance> T_world_place;  // unset: no link points lead there from the root map so far
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
};

struct LinkPointFilter {
  std::optional<MapId> map = std::nullopt;  // with an anchor in it
  std::optional<graph::LinkPointKind> kind = std::nullopt;
  std::optional<graph::PassageState> state = std::nullopt;  // as stored, expired or not
  std::optional<graph::LinkPointUse> use = std::nullopt;
  std::optional<bool> candidate = std::nullopt;
  std::optional<std::string> tag = std::nullopt;  // exactly
};

// Where to look, in the world frame.
struct LinkPointCircle {
  Eigen::Vector2d center;  // m
  double radius = 0.0;     // m; infinite for the nearest ones wherever they are
};
struct LinkPointQuery {
  std::variant<LinkPointCircle, std::vector<Eigen::Vector2d>> area;  // or a simple polygon
  std::optional<int> level;                                          // unset: on all
  std::optional<bool> candidate;                                     // unset: candidates and link points
  bool with_unused = false;                                          // suspended and switched off ones too
  int limit = 1000;                                                  // the nearest first; of a polygon the first by id
};

struct FoundLinkPoints {
  std::vector<StoredLinkPoint> link_points;
  std::int64_t graph_version = 0;  // that they are of
};

// Link points, candidates and what was seen of them. Every change raises the site's graph version, and changes of one
// site follow one another. Thread-safe; errors common to all stores: see SiteStore.
class LinkPointStore {
 public:
  explicit LinkPointStore(postgres::Pool& pool) : pool_(pool) {}

  // One anchor makes a candidate. NOT_FOUND naming the site or map that is missing; ALREADY_EXISTS where the id is
  // taken, or where it is redundant (see migrations/deploy/link_points.sql), naming the other one; INVALID_ARGUMENT
  // naming the anchor that is not finite, whose covariance is none, or whose map comes twice. `request_id` as in
  // SiteStore.
  absl::StatusOr<StoredLinkPoint> Create(const CallContext& context, const StoredLinkPoint& link_point,
                                         const std::string& request_id) const;
  // The place seen from one more map: a candidate becomes a link point. ABORTED on a stale `etag` (0: any); NOT_FOUND;
  // ALREADY_EXISTS where it has an anchor in that map, or is redundant then and not `force`.
  absl::StatusOr<StoredLinkPoint> AddAnchor(const CallContext& context, const SiteId& site, const LinkPointId& id,
                                            std::int64_t etag, const graph::Anchor& anchor, bool force) const;
  absl::StatusOr<StoredLinkPoint> Get(const CallContext& context, const SiteId& site, const LinkPointId& id) const;
  // By id.
  absl::StatusOr<std::vector<StoredLinkPoint>> List(const CallContext& context, const SiteId& site,
                                                    const LinkPointFilter& filter, const PageRequest& page) const;
  // Writes all but use and what the store sets; anchors that are gone take their evidence along. ABORTED on a stale
  // `etag`, NOT_FOUND, ALREADY_EXISTS as in Create.
  absl::StatusOr<StoredLinkPoint> Update(const CallContext& context, const StoredLinkPoint& link_point) const;
  // A suspended one takes no part in chains, routes and the optimisation. ABORTED on a stale `etag` (0: any);
  // ALREADY_EXISTS where one was made in the place of the suspended one; NOT_FOUND.
  absl::StatusOr<StoredLinkPoint> SetSuspended(const CallContext& context, const SiteId& site, const LinkPointId& id,
                                               std::int64_t etag, bool suspended) const;
  // With its evidence. ABORTED on a stale `etag` (0: any); NOT_FOUND.
  absl::Status Delete(const CallContext& context, const SiteId& site, const LinkPointId& id, std::int64_t etag) const;

  // One indexed query. Distances are those of the positions as the graph was last solved.
  absl::StatusOr<FoundLinkPoints> Find(const CallContext& context, const SiteId& site,
                                       const LinkPointQuery& query) const;
  // Those that have no place in the world yet, by id.
  absl::StatusOr<std::vector<StoredLinkPoint>> ListUnplaced(const CallContext& context, const SiteId& site,
                                                            int limit) const;

  // Takes the place of what the anchor had of this kind. The blob must be stored: INVALID_ARGUMENT otherwise;
  // NOT_FOUND where the link point has no anchor in that map.
  absl::Status PutEvidence(const CallContext& context, const SiteId& site, const Evidence& evidence) const;
  // Of those link points, by link point, map and kind; of one kind the nearest to the door's moment first.
  absl::StatusOr<std::vector<Evidence>> ListEvidence(const CallContext& context, const SiteId& site,
                                                     const std::vector<LinkPointId>& link_points) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage

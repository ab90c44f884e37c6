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
#include "storage/maps/map_store.h"
#include "storage/request_id.h"

namespace enfilade::storage {

// What a map showed of a place. The numbers are in the database: never reuse one.
enum class EvidenceKind : std::int16_t { kFrontImage = 1, kRearImage = 2, kCloud = 3 };

struct Evidence {
  LinkPointId link_point;
  MapId map;  // of the anchor that it belongs to
  EvidenceKind kind = EvidenceKind::kFrontImage;
  std::int16_t encoding = 0;  // ImageEncoding or CloudEncoding, by `kind`
  sensor::BlobRef content;
  TimeNs time = 0;  // when it was recorded
  // The robot's pose in `map` at that time; unset: unknown, taken as the anchor.
  std::optional<Pose2> T_map_robot = {};
};

struct StoredLinkPoint {
  SiteId site;
  graph::LinkPoint point;                  // `graph_version` is set by the store
  std::optional<Environment> environment;  // unset: unknown
  bool forced = false;                     // may stand beside one that joins the same maps at the same place
  // Set by the store.
  std::optional<PoseWithCovariance> T_world_place;  // unset: no link points lead there from the root map
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
};

// A place seen from one more map.
struct NewAnchor {
  LinkPointId link_point;
  std::int64_t etag = 0;  // of the link point; 0: any
  graph::Anchor anchor;
  bool force = false;  // accept a redundant link point
};

// One of several changes that are made together.
struct LinkPointCreation {
  StoredLinkPoint link_point;
};
struct LinkPointUpdate {
  StoredLinkPoint link_point;  // with the etag of what it changes
};
struct LinkPointSuspension {
  LinkPointId link_point;
  std::int64_t etag = 0;  // 0: any
  bool suspended = true;
};
struct LinkPointDeletion {
  LinkPointId link_point;
  std::int64_t etag = 0;  // 0: any
};
using LinkPointChange = std::variant<LinkPointCreation, LinkPointUpdate, LinkPointSuspension, LinkPointDeletion>;
const LinkPointId& LinkPointOf(const LinkPointChange& change);

struct ChangedLinkPoints {
  std::int64_t graph_version = 0;  // after the changes
  // Those that were changed and not deleted, each once, in the order of their first changes.
  std::vector<StoredLinkPoint> link_points;
};

// All conditions that are set must hold.
struct LinkPointFilter {
  std::optional<MapId> map = std::nullopt;  // with an anchor in it
  std::optional<graph::LinkPointKind> kind = std::nullopt;
  std::optional<graph::PassageState> state = std::nullopt;  // as stored, even if expired
  std::optional<graph::LinkPointUse> use = std::nullopt;
  std::optional<bool> candidate = std::nullopt;
  std::optional<std::string> tag = std::nullopt;  // exactly
};

// An area in the world frame.
struct LinkPointCircle {
  Eigen::Vector2d center;  // m
  double radius = 0.0;     // m; infinity: the nearest ones at any distance
};
struct LinkPointQuery {
  std::variant<LinkPointCircle, std::vector<Eigen::Vector2d>> area;  // or a simple polygon
  std::optional<int> level;                                          // unset: all levels
  std::optional<bool> candidate;                                     // unset: candidates and link points
  bool with_unused = false;                                          // includes suspended and switched off ones
  int limit = 1000;                                                  // circle: nearest first; polygon: by id
};

struct FoundLinkPoints {
  std::vector<StoredLinkPoint> link_points;
  std::int64_t graph_version = 0;  // of the site when they were read
};

// INVALID_ARGUMENT naming the anchor: no anchor at all, a map that comes twice, a pose that is not finite, an invalid
// covariance.
absl::Status ValidateAnchors(const std::vector<graph::Anchor>& anchors);
// INVALID_ARGUMENT: as ValidateAnchors, and a direction without an anchor.
absl::Status ValidateLinkPoint(const StoredLinkPoint& link_point);
// INVALID_ARGUMENT: an area that is not finite, a negative radius, fewer than three or more than 1,000 corners.
absl::Status ValidateQuery(const LinkPointQuery& query);

// Read access to link points. Thread-safe; errors common to all stores: see SiteStore.
class LinkPointReader {
 public:
  virtual ~LinkPointReader() = default;

  // NOT_FOUND.
  virtual absl::StatusOr<StoredLinkPoint> Get(const CallContext& context, const SiteId& site,
                                              const LinkPointId& id) const = 0;
  // By id.
  virtual absl::StatusOr<std::vector<StoredLinkPoint>> List(const CallContext& context, const SiteId& site,
                                                            const LinkPointFilter& filter,
                                                            const PageRequest& page) const = 0;
  // One indexed query. Distances are to the positions that the last solution of the graph gave. INVALID_ARGUMENT as
  // in ValidateQuery.
  virtual absl::StatusOr<FoundLinkPoints> Find(const CallContext& context, const SiteId& site,
                                               const LinkPointQuery& query) const = 0;
  // Those without a pose in the world frame, by id.
  virtual absl::StatusOr<std::vector<StoredLinkPoint>> ListUnplaced(const CallContext& context, const SiteId& site,
                                                                    int limit) const = 0;
  // Of `link_points`, by link point, map and kind; within a kind by distance in time from the passage of the door.
  virtual absl::StatusOr<std::vector<Evidence>> ListEvidence(const CallContext& context, const SiteId& site,
                                                             const std::vector<LinkPointId>& link_points) const = 0;
};

// Link points, candidates and their evidence. Every change raises the site's graph version; changes of one site are
// made one after another. Thread-safe; errors common to all stores: see SiteStore.
class LinkPointStore : public LinkPointReader {
 public:
  // With one anchor it is a candidate. NOT_FOUND naming the missing site or map; ALREADY_EXISTS if the id is taken, or
  // the link point is redundant (CheckNotRedundant), naming the other one; INVALID_ARGUMENT naming the anchor that
  // is not finite, has an invalid covariance, or repeats a map. `request_id` as in SiteStore.
  virtual absl::StatusOr<StoredLinkPoint> Create(const CallContext& context, const StoredLinkPoint& link_point,
                                                 const RequestId& request_id) const = 0;
  // Promotes a candidate to a link point. ABORTED on a stale etag; NOT_FOUND; ALREADY_EXISTS if it has an anchor in
  // that map, or becomes redundant without `force`.
  virtual absl::StatusOr<StoredLinkPoint> AddAnchor(const CallContext& context, const SiteId& site,
                                                    const NewAnchor& added) const = 0;
  // Writes all fields but `use` and those set by the store. Removing an anchor removes its evidence. ABORTED on a stale
  // `etag`, NOT_FOUND, ALREADY_EXISTS as in Create.
  virtual absl::StatusOr<StoredLinkPoint> Update(const CallContext& context,
                                                 const StoredLinkPoint& link_point) const = 0;
  // A suspended link point takes no part in chains, routes and the optimisation. ABORTED on a stale `etag` (0: any);
  // ALREADY_EXISTS if one was made in the place of the suspended one; NOT_FOUND.
  virtual absl::StatusOr<StoredLinkPoint> SetSuspended(const CallContext& context, const SiteId& site,
                                                       const LinkPointId& id, std::int64_t etag,
                                                       bool suspended) const = 0;
  // Deletes its evidence, too. ABORTED on a stale `etag` (0: any); NOT_FOUND.
  virtual absl::Status Delete(const CallContext& context, const SiteId& site, const LinkPointId& id,
                              std::int64_t etag) const = 0;
  // Makes all of `changes`, one after the other, or none: their errors are those of the methods above, and name the
  // change: "changes[2]: ...". Each raises the graph's version. INVALID_ARGUMENT: no changes.
  virtual absl::StatusOr<ChangedLinkPoints> Change(const CallContext& context, const SiteId& site,
                                                   const std::vector<LinkPointChange>& changes) const = 0;
  // Replaces the anchor's evidence of this kind. The blob must be stored: INVALID_ARGUMENT otherwise; NOT_FOUND if the
  // link point has no anchor in that map.
  virtual absl::Status PutEvidence(const CallContext& context, const SiteId& site, const Evidence& evidence) const = 0;
};

}  // namespace enfilade::storage

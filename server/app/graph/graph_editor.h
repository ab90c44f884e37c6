// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "server/app/graph/site_graphs.h"
#include "storage/call_context.h"
#include "storage/graph/graph_store.h"
#include "storage/graph/link_point_store.h"
#include "storage/maps/map_store.h"

namespace enfilade::server {

// The only way for RPCs to change what a site's graph is made of: maps, link points with their anchors and evidence,
// and control points. Calls the store, then marks the graph as changed, so that this server's answers include the
// change immediately. Contracts and errors are those of the stores' methods of the same names. Thread-safe.
class GraphEditor {
 public:
  struct Stores {
    const storage::MapStore& maps;
    const storage::LinkPointStore& link_points;
    const storage::GraphStore& graphs;
  };

  GraphEditor(const Stores& stores, SiteGraphs& graphs) : stores_(stores), graphs_(graphs) {}

  absl::StatusOr<storage::Map> CreateMap(const storage::CallContext& context, const storage::Map& map,
                                         const storage::RequestId& request_id);
  absl::StatusOr<storage::Map> UpdateMap(const storage::CallContext& context, const storage::Map& map);
  absl::Status DeleteMap(const storage::CallContext& context, const SiteId& site, const MapId& map, std::int64_t etag,
                         bool force);

  absl::StatusOr<storage::StoredLinkPoint> CreateLinkPoint(const storage::CallContext& context,
                                                           const storage::StoredLinkPoint& link_point,
                                                           const storage::RequestId& request_id);
  absl::StatusOr<storage::StoredLinkPoint> AddAnchor(const storage::CallContext& context, const SiteId& site,
                                                     const storage::NewAnchor& added);
  absl::StatusOr<storage::StoredLinkPoint> UpdateLinkPoint(const storage::CallContext& context,
                                                           const storage::StoredLinkPoint& link_point);
  absl::StatusOr<storage::StoredLinkPoint> SetSuspended(const storage::CallContext& context, const SiteId& site,
                                                        const LinkPointId& id, std::int64_t etag, bool suspended);
  absl::Status DeleteLinkPoint(const storage::CallContext& context, const SiteId& site, const LinkPointId& id,
                               std::int64_t etag);
  absl::StatusOr<storage::ChangedLinkPoints> ChangeLinkPoints(const storage::CallContext& context, const SiteId& site,
                                                              const std::vector<storage::LinkPointChange>& changes);
  absl::Status PutEvidence(const storage::CallContext& context, const SiteId& site, const storage::Evidence& evidence);

  absl::StatusOr<std::int64_t> SetControlPoints(const storage::CallContext& context, const SiteId& site,
                                                const std::vector<storage::ControlPoint>& points);

 private:
  // Returns `result` after marking the site's graph as changed, unless the store refused the change.
  template <typename Result>
  Result Changed(const SiteId& site, Result result);

  const Stores stores_;
  SiteGraphs& graphs_;
};

}  // namespace enfilade::server

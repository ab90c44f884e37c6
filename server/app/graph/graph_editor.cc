// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_editor.h"

#include <utility>

namespace enfilade::server {
namespace {

const absl::Status& StatusOfEdit(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusOfEdit(const absl::StatusOr<T>& result) {
  return result.status();
}

// After these errors the change may have been committed.
bool IsOutcomeUnknown(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) || absl::IsCancelled(status);
}

}  // namespace

template <typename Result>
Result GraphEditor::Changed(const SiteId& site, Result result) {
  const absl::Status& status = StatusOfEdit(result);
  if (status.ok() || IsOutcomeUnknown(status)) graphs_.MarkChanged(site);
  return result;
}

absl::StatusOr<storage::Map> GraphEditor::CreateMap(const storage::CallContext& context, const storage::Map& map,
                                                    const storage::RequestId& request_id) {
  return Changed(map.site, stores_.maps.Create(context, map, request_id));
}

absl::StatusOr<storage::Map> GraphEditor::UpdateMap(const storage::CallContext& context, const storage::Map& map) {
  return Changed(map.site, stores_.maps.Update(context, map));
}

absl::Status GraphEditor::DeleteMap(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                    std::int64_t etag, bool force) {
  return Changed(site, stores_.maps.Delete(context, site, map, etag, force));
}

absl::StatusOr<storage::StoredLinkPoint> GraphEditor::CreateLinkPoint(const storage::CallContext& context,
                                                                      const storage::StoredLinkPoint& link_point,
                                                                      const storage::RequestId& request_id) {
  return Changed(link_point.site, stores_.link_points.Create(context, link_point, request_id));
}

absl::StatusOr<storage::StoredLinkPoint> GraphEditor::AddAnchor(const storage::CallContext& context, const SiteId& site,
                                                                const storage::NewAnchor& added) {
  return Changed(site, stores_.link_points.AddAnchor(context, site, added));
}

absl::StatusOr<storage::StoredLinkPoint> GraphEditor::UpdateLinkPoint(const storage::CallContext& context,
                                                                      const storage::StoredLinkPoint& link_point) {
  return Changed(link_point.site, stores_.link_points.Update(context, link_point));
}

absl::StatusOr<storage::StoredLinkPoint> GraphEditor::SetSuspended(const storage::CallContext& context,
                                                                   const SiteId& site, const LinkPointId& id,
                                                                   std::int64_t etag, bool suspended) {
  return Changed(site, stores_.link_points.SetSuspended(context, site, id, etag, suspended));
}

absl::Status GraphEditor::DeleteLinkPoint(const storage::CallContext& context, const SiteId& site,
                                          const LinkPointId& id, std::int64_t etag) {
  return Changed(site, stores_.link_points.Delete(context, site, id, etag));
}

absl::StatusOr<storage::ChangedLinkPoints> GraphEditor::ChangeLinkPoints(
    const storage::CallContext& context, const SiteId& site, const std::vector<storage::LinkPointChange>& changes) {
  return Changed(site, stores_.link_points.Change(context, site, changes));
}

absl::Status GraphEditor::PutEvidence(const storage::CallContext& context, const SiteId& site,
                                      const storage::Evidence& evidence) {
  return Changed(site, stores_.link_points.PutEvidence(context, site, evidence));
}

absl::StatusOr<std::int64_t> GraphEditor::SetControlPoints(const storage::CallContext& context, const SiteId& site,
                                                           const std::vector<storage::ControlPoint>& points) {
  return Changed(site, stores_.graphs.SetControlPoints(context, site, points));
}

}  // namespace enfilade::server

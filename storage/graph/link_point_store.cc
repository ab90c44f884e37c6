// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/link_point_store.h"

#include <set>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/covariance.h"

namespace enfilade::storage {
namespace {

const LinkPointId& IdOfChange(const LinkPointCreation& change) { return change.link_point.point.id; }
const LinkPointId& IdOfChange(const LinkPointUpdate& change) { return change.link_point.point.id; }
const LinkPointId& IdOfChange(const LinkPointSuspension& change) { return change.link_point; }
const LinkPointId& IdOfChange(const LinkPointDeletion& change) { return change.link_point; }

}  // namespace

const LinkPointId& LinkPointOf(const LinkPointChange& change) {
  return std::visit([](const auto& one) -> const LinkPointId& { return IdOfChange(one); }, change);
}

absl::Status ValidateAnchors(const std::vector<graph::Anchor>& anchors) {
  if (anchors.empty()) return InvalidArgument("anchors are missing: a link point has at least one");
  std::set<MapId> maps;
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    const graph::Anchor& anchor = anchors[i];
    if (!maps.insert(anchor.map).second) {
      return InvalidArgument("anchors[{}]: the link point already has an anchor in the map \"{}\"", i,
                             anchor.map.value());
    }
    if (!IsFinite(anchor.T_map_place)) return InvalidArgument("anchors[{}].pose is not finite", i);
    ENFILADE_RETURN_IF_ERROR(WithContext(ValidateMeasuredCovariance(anchor.covariance), fmt::format("anchors[{}]", i)));
  }
  return absl::OkStatus();
}

absl::Status ValidateLinkPoint(const StoredLinkPoint& link_point) {
  ENFILADE_RETURN_IF_ERROR(ValidateAnchors(link_point.point.anchors));
  const MapId& direction = link_point.point.direction;
  if (!direction.empty() && !link_point.point.FindAnchor(direction)) {
    return InvalidArgument("direction is the map \"{}\": the link point has no anchor in it", direction.value());
  }
  return absl::OkStatus();
}

// Whether a point is in a polygon takes time for each corner.
constexpr std::size_t kMaxPolygonCorners = 1000;

absl::Status ValidateQuery(const LinkPointQuery& query) {
  if (const auto* circle = std::get_if<LinkPointCircle>(&query.area)) {
    if (!circle->center.allFinite()) return InvalidArgument("the center is not finite");
    if (!(circle->radius >= 0.0)) return InvalidArgument("the radius is {}: expected 0 or more", circle->radius);
    return absl::OkStatus();
  }
  const auto& polygon = std::get<std::vector<Eigen::Vector2d>>(query.area);
  if (polygon.size() < 3) return InvalidArgument("the polygon has {} corners: at least 3 are needed", polygon.size());
  if (polygon.size() > kMaxPolygonCorners) {
    return InvalidArgument("the polygon has {} corners: at most {} are allowed", polygon.size(), kMaxPolygonCorners);
  }
  for (const Eigen::Vector2d& corner : polygon) {
    if (!corner.allFinite()) return InvalidArgument("the polygon has a corner that is not finite");
  }
  return absl::OkStatus();
}

}  // namespace enfilade::storage

// SPDX-License-Identifier: Apache-2.0
#include "core/graph/validate_link_point.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/covariance.h"

namespace enfilade::graph {

absl::Status ValidateLinkPoint(const LinkPoint& link_point) {
  if (link_point.id.empty()) return InvalidArgument("the link point has no id");
  const std::string& id = link_point.id.value();
  if (link_point.anchors.empty()) return InvalidArgument("link point {} has no anchor", id);
  for (const Anchor& anchor : link_point.anchors) {
    if (link_point.FindAnchor(anchor.map) != &anchor) {
      return InvalidArgument("link point {} has two anchors in map {}", id, anchor.map.value());
    }
    const std::string where = fmt::format("link point {}, its anchor in map {}", id, anchor.map.value());
    if (!IsFinite(anchor.T_map_place)) return InvalidArgument("{}: the pose is not finite", where);
    ENFILADE_RETURN_IF_ERROR(WithContext(ValidateCovariance(anchor.covariance), where));
  }
  return absl::OkStatus();
}

}  // namespace enfilade::graph

// SPDX-License-Identifier: Apache-2.0
#include "core/rearrange/rearrangement.h"

#include <set>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/validate_link_point.h"

namespace enfilade::rearrange {
namespace {

template <typename T, typename IdOf>
absl::Status CheckUnique(const std::vector<T>& items, const IdOf& id_of, std::string_view what) {
  std::set<std::string> seen;
  for (const T& item : items) {
    const std::string id = id_of(item).value();
    if (!IsValidResourceId(id)) return InvalidArgument("{} \"{}\" is not a valid id", what, id);
    if (!seen.insert(id).second) return InvalidArgument("{} \"{}\" is given twice", what, id);
  }
  return absl::OkStatus();
}

absl::Status ValidateCuts(const Rearrangement& rearrangement) {
  ENFILADE_RETURN_IF_ERROR(CheckUnique(
      rearrangement.cuts, [](const SessionCut& cut) { return cut.rest; }, "the rest of a session"));
  std::set<std::pair<SessionId, std::int64_t>> seen;
  for (const SessionCut& cut : rearrangement.cuts) {
    const std::string& id = cut.session.value();
    if (!IsValidResourceId(id)) return InvalidArgument("the session to be cut \"{}\" is not a valid id", id);
    if (cut.first_sequence <= 1) {
      return InvalidArgument("session {} cannot be cut before record {}: nothing would be left", id,
                             cut.first_sequence);
    }
    if (!seen.emplace(cut.session, cut.first_sequence).second) {
      return InvalidArgument("session {} is cut twice before record {}", id, cut.first_sequence);
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateRedirects(const Rearrangement& rearrangement) {
  std::set<MapId> gone;
  for (const MapRedirect& redirect : rearrangement.redirects) gone.insert(redirect.from);
  for (const MapRedirect& redirect : rearrangement.redirects) {
    if (!IsFinite(redirect.T_to_from)) return InvalidArgument("map {}: T_to_from is not finite", redirect.from.value());
    if (gone.contains(redirect.to)) {
      return InvalidArgument("map {} would lead to map {}, which disappears itself", redirect.from.value(),
                             redirect.to.value());
    }
  }
  for (const SessionMove& move : rearrangement.moves) {
    if (!IsFinite(move.T_to_from)) return InvalidArgument("session {}: T_to_from is not finite", move.session.value());
    if (gone.contains(move.to)) {
      return InvalidArgument("session {} would move into map {}, which disappears", move.session.value(),
                             move.to.value());
    }
  }
  for (const graph::LinkPoint& point : rearrangement.link_points) {
    for (const graph::Anchor& anchor : point.anchors) {
      if (!gone.contains(anchor.map)) continue;
      return InvalidArgument("link point {} has an anchor in map {}, which disappears", point.id.value(),
                             anchor.map.value());
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateLinkPoints(const Rearrangement& rearrangement) {
  std::set<LinkPointId> removed(rearrangement.removed_link_points.begin(), rearrangement.removed_link_points.end());
  for (const graph::LinkPoint& point : rearrangement.link_points) {
    if (removed.contains(point.id))
      return InvalidArgument("link point {} is both stored and removed", point.id.value());
    ENFILADE_RETURN_IF_ERROR(graph::ValidateLinkPoint(point));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const Rearrangement& rearrangement) {
  ENFILADE_RETURN_IF_ERROR(CheckUnique(
      rearrangement.new_maps, [](const MapSeed& map) { return map.id; }, "the new map"));
  ENFILADE_RETURN_IF_ERROR(CheckUnique(
      rearrangement.moves, [](const SessionMove& move) { return move.session; }, "the session to be moved"));
  ENFILADE_RETURN_IF_ERROR(CheckUnique(
      rearrangement.redirects, [](const MapRedirect& redirect) { return redirect.from; }, "the map"));
  ENFILADE_RETURN_IF_ERROR(CheckUnique(
      rearrangement.link_points, [](const graph::LinkPoint& point) { return point.id; }, "the link point"));
  ENFILADE_RETURN_IF_ERROR(CheckUnique(
      rearrangement.removed_link_points, [](const LinkPointId& id) { return id; }, "the link point to be removed"));
  ENFILADE_RETURN_IF_ERROR(ValidateCuts(rearrangement));
  ENFILADE_RETURN_IF_ERROR(ValidateRedirects(rearrangement));
  return ValidateLinkPoints(rearrangement);
}

PoseWithCovariance Moved(const Pose2& T_to_from, const PoseWithCovariance& T_from_x) {
  return Compose(PoseWithCovariance{T_to_from, Eigen::Matrix3d::Zero()}, T_from_x);
}

}  // namespace enfilade::rearrange

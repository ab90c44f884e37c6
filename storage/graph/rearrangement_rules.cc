// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/rearrangement_rules.h"

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"

namespace enfilade::storage {
namespace {

absl::Status CheckMoved(const SiteId& site, const SessionId& session,
                        const std::map<SessionId, SessionToRearrange>& sessions) {
  const auto found = sessions.find(session);
  const std::string name = NameOf(site, session);
  if (found == sessions.end()) return NotFound("{} does not exist", name);
  const SessionToRearrange& stored = found->second;
  if (stored.state == SessionState::kRecording) return FailedPrecondition("{} is still recording", name);
  if (stored.state == SessionState::kFinished) return FailedPrecondition("{} is still being mapped", name);
  if (stored.map.empty()) return FailedPrecondition("{} has no map", name);
  return absl::OkStatus();
}

}  // namespace

std::string NameOfRearrangement(const SiteId& site, const rearrange::RearrangementId& id) {
  return fmt::format("{}/rearrangements/{}", NameOf(site), id.value());
}

std::string ResourceOfRearrangement(const rearrange::RearrangementId& id) { return "rearrangements/" + id.value(); }

absl::Status ValidateToApply(const rearrange::Rearrangement& rearrangement) {
  ENFILADE_RETURN_IF_ERROR(rearrange::Validate(rearrangement));
  if (rearrangement.empty()) return InvalidArgument("the rearrangement changes nothing");
  return absl::OkStatus();
}

absl::Status CheckRearrangedMaps(const SiteId& site, const rearrange::Rearrangement& rearrangement,
                                 std::map<MapId, bool> redirected) {
  for (const rearrange::MapSeed& seed : rearrangement.new_maps) redirected.emplace(seed.id, false);
  const auto check = [&](const MapId& map) {
    const auto found = redirected.find(map);
    if (found == redirected.end()) return NotFound("{} does not exist", NameOf(site, map));
    if (found->second) return NotFound("{} was merged into another map", NameOf(site, map));
    return absl::OkStatus();
  };
  for (const rearrange::SessionMove& move : rearrangement.moves) ENFILADE_RETURN_IF_ERROR(check(move.to));
  for (const rearrange::MapRedirect& redirect : rearrangement.redirects) {
    ENFILADE_RETURN_IF_ERROR(check(redirect.from));
    ENFILADE_RETURN_IF_ERROR(check(redirect.to));
  }
  return absl::OkStatus();
}

absl::Status CheckRearrangedSessions(const SiteId& site, const rearrange::Rearrangement& rearrangement,
                                     const std::map<SessionId, SessionToRearrange>& sessions) {
  std::map<SessionId, SessionId> cut_from;
  for (const rearrange::SessionCut& cut : rearrangement.cuts) {
    ENFILADE_RETURN_IF_ERROR(CheckMoved(site, cut.session, sessions));
    const SessionToRearrange& stored = sessions.at(cut.session);
    if (stored.state != SessionState::kMapped || stored.records_deleted) {
      return FailedPrecondition("{} cannot be cut: {}", NameOf(site, cut.session),
                                stored.records_deleted ? "its records have been deleted" : "its mapping failed");
    }
    cut_from[cut.rest] = cut.session;
  }
  for (const rearrange::SessionMove& move : rearrangement.moves) {
    const auto rest = cut_from.find(move.session);
    ENFILADE_RETURN_IF_ERROR(CheckMoved(site, rest == cut_from.end() ? move.session : rest->second, sessions));
  }
  return absl::OkStatus();
}

absl::Status NothingToCutOff(const SiteId& site, const SessionId& session, std::int64_t first_sequence) {
  return FailedPrecondition("{} has no keyframes on both sides of record {}: there is nothing to cut off",
                            NameOf(site, session), first_sequence);
}

absl::Status SessionIsLeft(const SiteId& site, const SessionId& session, const MapId& map) {
  return FailedPrecondition("{} is still in map {}, which would disappear", NameOf(site, session), map.value());
}

absl::Status AnchorIsLeft(const SiteId& site, const LinkPointId& link_point, const MapId& map) {
  return FailedPrecondition("{} still has an anchor in map {}, which would disappear", NameOf(site, link_point),
                            map.value());
}

absl::Status RootWouldDisappear(const MapId& map) {
  return FailedPrecondition("map {} carries the site's world frame and cannot disappear", map.value());
}

std::string DescribeImage(std::string_view relation, std::string_view key) {
  if (relation == image::kControlPoints) return "the control points";
  if (relation == image::kLayers) return fmt::format("the layers of map {}", key);
  if (relation == image::kSlam) return fmt::format("the keyframes of session {}", key);
  if (relation == image::kClosures) return fmt::format("the loop closures of session {}", key);
  if (relation == image::kLinkPoint) return fmt::format("link point {}", key);
  if (relation == image::kVerdict) return fmt::format("the verdict {}", key);
  return fmt::format("{} {}", relation, key);
}

absl::Status AlreadyUndone(const std::string& name) { return FailedPrecondition("{} has been undone already", name); }

absl::Status UndoExpired(const std::string& name) {
  return FailedPrecondition("{} can no longer be undone: what that needs is kept for a time only, and has been deleted",
                            name);
}

absl::Status ChangedSince(const std::string& name, std::string_view relation, std::string_view key) {
  return FailedPrecondition("{} cannot be undone: {} has been changed since", name, DescribeImage(relation, key));
}

absl::Status HasComeSince(const std::string& name, const std::string& what, const MapId& map) {
  return FailedPrecondition("{} cannot be undone: {} has come into map {} since", name, what, map.value());
}

}  // namespace enfilade::storage

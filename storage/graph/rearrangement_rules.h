// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "core/base/ids.h"
#include "core/rearrange/rearrangement.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage {

// What every RearrangementStore checks, and the errors that it returns.

// sites/{site}/rearrangements/{rearrangement}
std::string NameOfRearrangement(const SiteId& site, const rearrange::RearrangementId& id);
// Of a version of the graph: rearrangements/{rearrangement}
std::string ResourceOfRearrangement(const rearrange::RearrangementId& id);

// INVALID_ARGUMENT: it breaks a rule (rearrange::Validate) or changes nothing.
absl::Status ValidateToApply(const rearrange::Rearrangement& rearrangement);

// Whether each of the maps that the rearrangement names is redirected; one that does not exist is missing. NOT_FOUND
// naming a map that is redirected or missing.
absl::Status CheckRearrangedMaps(const SiteId& site, const rearrange::Rearrangement& rearrangement,
                                 std::map<MapId, bool> redirected);

struct SessionToRearrange {
  MapId map = {};  // empty: none
  SessionState state = SessionState::kRecording;
  bool records_deleted = false;
};
// `sessions`: those that are cut or moved; one that does not exist is missing. NOT_FOUND; FAILED_PRECONDITION: a
// session that is still recorded or mapped, that has no map, or that cannot be cut.
absl::Status CheckRearrangedSessions(const SiteId& site, const rearrange::Rearrangement& rearrangement,
                                     const std::map<SessionId, SessionToRearrange>& sessions);

// FAILED_PRECONDITION each.
absl::Status NothingToCutOff(const SiteId& site, const SessionId& session, std::int64_t first_sequence);
absl::Status SessionIsLeft(const SiteId& site, const SessionId& session, const MapId& map);
absl::Status AnchorIsLeft(const SiteId& site, const LinkPointId& link_point, const MapId& map);
absl::Status RootWouldDisappear(const MapId& map);

// What a journal has the images of: the names of rearrangement_images.relation in the database.
namespace image {
inline constexpr std::string_view kMap = "map", kLayers = "layers", kPlace = "place", kSession = "session",
                                  kSlam = "slam", kClosures = "closures", kVerdict = "verdict",
                                  kLinkPoint = "link_point", kControlPoints = "control_points",
                                  kRobotPose = "robot_pose", kArea = "area";
}  // namespace image
// For people: "the keyframes of session s1".
std::string DescribeImage(std::string_view relation, std::string_view key);

// Why the rearrangement of that resource name cannot be undone. FAILED_PRECONDITION each.
absl::Status AlreadyUndone(const std::string& name);
absl::Status UndoExpired(const std::string& name);
absl::Status ChangedSince(const std::string& name, std::string_view relation, std::string_view key);
// `what`: "session s1"
absl::Status HasComeSince(const std::string& name, const std::string& what, const MapId& map);

}  // namespace enfilade::storage

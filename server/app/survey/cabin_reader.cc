// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/cabin_reader.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {

absl::Status CabinReader::PlaceCabin(const storage::Session& stored, const survey::SurveyedSession& first,
                                     survey::LevelSurvey& level) const {
  const std::optional<Pose2> T_level_map = survey::PlaceOf(first);
  const std::optional<SessionId>& ride = stored.entry.previous;
  if (!ride || !T_level_map || !first.T_map_entry) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<MapId> cabin, reader_.FindMap(*ride));
  if (!cabin || !rides_.cabins.contains(*cabin)) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<sensor::DoorReport> passage, reader_.FindPassage(*ride));
  if (!passage) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<Pose2> T_cabin_robot, reader_.FindPose(*ride, passage->time));
  if (T_cabin_robot) level.cabin_places.emplace(*cabin, *T_level_map * *first.T_map_entry * Inverse(*T_cabin_robot));
  return absl::OkStatus();
}

std::optional<survey::CabinEntry> CabinReader::EntryOf(const closure::DoorVerdict& verdict,
                                                       const survey::SurveyedSession& session, TimeNs left) const {
  if (!verdict.link_point || !verdict.entered_map) return std::nullopt;
  // The verdict's map may have been merged since.
  const auto next = rides_.next.find(session.id);
  const MapId& entered = next != rides_.next.end() ? next->second.second : *verdict.entered_map;
  if (!rides_.cabins.contains(entered)) return std::nullopt;
  survey::CabinEntry entry{.cabin = entered, .door = *verdict.link_point};
  std::copy_if(session.visits.begin(), session.visits.end(), std::back_inserter(entry.visits),
               [&](const survey::Visit& visit) { return visit.time > left; });
  return entry.visits.empty() ? std::nullopt : std::optional(std::move(entry));
}

absl::Status CabinReader::AddRideBegun(const survey::SurveyedSession& last, survey::LevelSurvey& level) const {
  const auto next = rides_.next.find(last.id);
  const std::optional<Pose2> T_level_map = survey::PlaceOf(last);
  if (!T_level_map || next == rides_.next.end()) return absl::OkStatus();
  const auto& [session, cabin] = next->second;
  if (!rides_.from_elsewhere.contains(session) || !rides_.cabins.contains(cabin)) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<sensor::DoorReport> passage, reader_.FindPassage(last.id));
  if (!passage) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<Pose2> T_map_robot, reader_.FindPose(last.id, passage->time));
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<Pose2> T_cabin_robot, reader_.FindFirstPose(session));
  if (!T_map_robot || !T_cabin_robot) return absl::OkStatus();
  survey::RideBegun ride{.session = session,
                         .cabin = cabin,
                         .T_level_robot = *T_level_map * *T_map_robot,
                         .T_cabin_robot = *T_cabin_robot};
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<closure::DoorVerdict> verdict, reader_.FindVerdict(session));
  if (verdict && verdict->decision == closure::DoorDecision::kLinkPointMade) ride.way_out = verdict->link_point;
  level.rides_begun.push_back(std::move(ride));
  return absl::OkStatus();
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/resource_name.h"

namespace enfilade::convert {

// Resource names (AIP-122), built and taken apart. Parsing gives INVALID_ARGUMENT naming the field, the name and the
// form that was expected.

struct MapName {
  SiteId site;
  MapId map;
};
struct RevisionName {
  SiteId site;
  MapId map;
  std::int64_t revision = 0;  // 0: the newest
};
struct MapDraftName {
  SiteId site;
  MapId map;
  MapDraftId draft;
};
struct MapAreaName {
  SiteId site;
  MapId map;
  MapAreaId area;
};
struct MapAliasName {
  SiteId site;
  MapId map;
  MapAliasId alias;
};
struct PriorMapName {
  SiteId site;
  PriorMapId prior_map;
};
struct LinkPointName {
  SiteId site;
  LinkPointId link_point;
};
struct RobotName {
  SiteId site;
  RobotId robot;
};
struct SessionName {
  SiteId site;
  SessionId session;
};

struct LoopClosureName {
  SiteId site;
  SessionId session;
  std::int64_t closure = 0;
};

struct DoorVerdictName {
  SiteId site;
  SessionId session;
  std::int64_t sequence = 0;  // of the report's record
};

struct RearrangementName {
  SiteId site;
  std::string rearrangement;
};

std::string NameOf(const MapName& name);
std::string NameOf(const RevisionName& name);
std::string NameOf(const MapDraftName& name);
std::string NameOf(const MapAreaName& name);
std::string NameOf(const MapAliasName& name);
std::string NameOf(const PriorMapName& name);
std::string NameOf(const LinkPointName& name);
std::string NameOf(const RobotName& name);
std::string NameOf(const SessionName& name);
std::string NameOf(const LoopClosureName& name);
std::string NameOf(const DoorVerdictName& name);
std::string NameOf(const RearrangementName& name);

absl::StatusOr<SiteId> ParseSiteName(std::string_view field, std::string_view name);
absl::StatusOr<MapName> ParseMapName(std::string_view field, std::string_view name);
// Takes a map's name too, meaning its newest revision.
absl::StatusOr<RevisionName> ParseMapOrRevisionName(std::string_view field, std::string_view name);
absl::StatusOr<RevisionName> ParseRevisionName(std::string_view field, std::string_view name);
absl::StatusOr<MapDraftName> ParseMapDraftName(std::string_view field, std::string_view name);
absl::StatusOr<MapAreaName> ParseMapAreaName(std::string_view field, std::string_view name);
absl::StatusOr<MapAliasName> ParseMapAliasName(std::string_view field, std::string_view name);
absl::StatusOr<PriorMapName> ParsePriorMapName(std::string_view field, std::string_view name);
absl::StatusOr<LinkPointName> ParseLinkPointName(std::string_view field, std::string_view name);
absl::StatusOr<RobotName> ParseRobotName(std::string_view field, std::string_view name);
absl::StatusOr<SessionName> ParseSessionName(std::string_view field, std::string_view name);
absl::StatusOr<LoopClosureName> ParseLoopClosureName(std::string_view field, std::string_view name);
absl::StatusOr<DoorVerdictName> ParseDoorVerdictName(std::string_view field, std::string_view name);
absl::StatusOr<RearrangementName> ParseRearrangementName(std::string_view field, std::string_view name);

}  // namespace enfilade::convert

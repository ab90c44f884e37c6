// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/names.h"

#include <charconv>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/status_macros.h"

namespace enfilade::convert {
namespace {

// The ids in a name of the form "sites/{site}/maps/{map}": those of `name` at the places in braces.
std::optional<std::vector<std::string>> Match(std::string_view form, std::string_view name) {
  std::vector<std::string> ids;
  while (true) {
    const std::string_view form_segment = form.substr(0, form.find('/'));
    const std::string_view segment = name.substr(0, name.find('/'));
    if (form_segment.front() == '{') {
      if (!IsValidResourceId(segment)) return std::nullopt;
      ids.emplace_back(segment);
    } else if (segment != form_segment) {
      return std::nullopt;
    }
    const bool form_ends = form_segment.size() == form.size();
    const bool name_ends = segment.size() == name.size();
    if (form_ends || name_ends) {
      if (form_ends && name_ends) return ids;
      return std::nullopt;
    }
    form.remove_prefix(form_segment.size() + 1);
    name.remove_prefix(segment.size() + 1);
  }
}

absl::Status Misnamed(std::string_view field, std::string_view name, std::string_view form) {
  return InvalidArgument("{} is \"{}\": expected {} with ids of 1 to 63 of a-z, 0-9 and \"-\"", field,
                         Excerpt(name, 200), form);
}

absl::StatusOr<std::vector<std::string>> MatchOrError(std::string_view form, std::string_view field,
                                                      std::string_view name) {
  if (auto ids = Match(form, name)) return *std::move(ids);
  return Misnamed(field, name, form);
}

std::optional<std::int64_t> ToNumber(const std::string& text) {
  std::int64_t number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

constexpr std::string_view kSiteForm = "sites/{site}";
constexpr std::string_view kMapForm = "sites/{site}/maps/{map}";
constexpr std::string_view kRevisionForm = "sites/{site}/maps/{map}/revisions/{revision}";
constexpr std::string_view kMapDraftForm = "sites/{site}/maps/{map}/drafts/{draft}";
constexpr std::string_view kMapAreaForm = "sites/{site}/maps/{map}/areas/{area}";
constexpr std::string_view kMapAliasForm = "sites/{site}/maps/{map}/aliases/{alias}";
constexpr std::string_view kPriorMapForm = "sites/{site}/priorMaps/{prior_map}";
constexpr std::string_view kLinkPointForm = "sites/{site}/linkPoints/{link_point}";
constexpr std::string_view kRobotForm = "sites/{site}/robots/{robot}";
constexpr std::string_view kSessionForm = "sites/{site}/sessions/{session}";
constexpr std::string_view kLoopClosureForm = "sites/{site}/sessions/{session}/closures/{closure}";
constexpr std::string_view kDoorVerdictForm = "sites/{site}/sessions/{session}/doors/{sequence}";
constexpr std::string_view kRearrangementForm = "sites/{site}/rearrangements/{rearrangement}";

}  // namespace

std::string NameOf(const MapName& name) { return NameOf(name.site, name.map); }
std::string NameOf(const RevisionName& name) {
  return NameOf(name.site, name.map) + "/revisions/" + std::to_string(name.revision);
}
std::string NameOf(const MapDraftName& name) { return NameOf(name.site, name.map, name.draft); }
std::string NameOf(const MapAreaName& name) { return NameOf(name.site, name.map, name.area); }
std::string NameOf(const MapAliasName& name) { return NameOf(name.site, name.map, name.alias); }
std::string NameOf(const PriorMapName& name) { return NameOf(name.site, name.prior_map); }
std::string NameOf(const LinkPointName& name) { return NameOf(name.site, name.link_point); }
std::string NameOf(const RobotName& name) { return NameOf(name.site, name.robot); }
std::string NameOf(const SessionName& name) { return NameOf(name.site, name.session); }
std::string NameOf(const LoopClosureName& name) {
  return NameOf(name.site, name.session) + "/closures/" + std::to_string(name.closure);
}

std::string NameOf(const DoorVerdictName& name) {
  return NameOf(name.site, name.session) + "/doors/" + std::to_string(name.sequence);
}

std::string NameOf(const RearrangementName& name) {
  return NameOf(name.site) + "/rearrangements/" + name.rearrangement;
}

absl::StatusOr<SiteId> ParseSiteName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kSiteForm, field, name));
  return SiteId(ids[0]);
}

absl::StatusOr<MapName> ParseMapName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kMapForm, field, name));
  return MapName{SiteId(ids[0]), MapId(ids[1])};
}

absl::StatusOr<RevisionName> ParseRevisionName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kRevisionForm, field, name));
  const std::optional<std::int64_t> revision = ToNumber(ids[2]);
  if (revision && *revision >= 1) return RevisionName{SiteId(ids[0]), MapId(ids[1]), *revision};
  return InvalidArgument("{} is \"{}\": revisions are numbers from 1 on", field, Excerpt(name, 200));
}

absl::StatusOr<RevisionName> ParseMapOrRevisionName(std::string_view field, std::string_view name) {
  if (const auto map = ParseMapName(field, name); map.ok()) return RevisionName{map->site, map->map, 0};
  return ParseRevisionName(field, name);
}

absl::StatusOr<MapDraftName> ParseMapDraftName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kMapDraftForm, field, name));
  return MapDraftName{SiteId(ids[0]), MapId(ids[1]), MapDraftId(ids[2])};
}

absl::StatusOr<MapAreaName> ParseMapAreaName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kMapAreaForm, field, name));
  return MapAreaName{SiteId(ids[0]), MapId(ids[1]), MapAreaId(ids[2])};
}

absl::StatusOr<MapAliasName> ParseMapAliasName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kMapAliasForm, field, name));
  return MapAliasName{SiteId(ids[0]), MapId(ids[1]), MapAliasId(ids[2])};
}

absl::StatusOr<PriorMapName> ParsePriorMapName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kPriorMapForm, field, name));
  return PriorMapName{SiteId(ids[0]), PriorMapId(ids[1])};
}

absl::StatusOr<LinkPointName> ParseLinkPointName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kLinkPointForm, field, name));
  return LinkPointName{SiteId(ids[0]), LinkPointId(ids[1])};
}

absl::StatusOr<RobotName> ParseRobotName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kRobotForm, field, name));
  return RobotName{SiteId(ids[0]), RobotId(ids[1])};
}

absl::StatusOr<SessionName> ParseSessionName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kSessionForm, field, name));
  return SessionName{SiteId(ids[0]), SessionId(ids[1])};
}

absl::StatusOr<LoopClosureName> ParseLoopClosureName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kLoopClosureForm, field, name));
  const std::optional<std::int64_t> closure = ToNumber(ids[2]);
  if (closure && *closure >= 0) return LoopClosureName{SiteId(ids[0]), SessionId(ids[1]), *closure};
  return InvalidArgument("{} is \"{}\": closures are numbers from 0 on", field, Excerpt(name, 200));
}

absl::StatusOr<DoorVerdictName> ParseDoorVerdictName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kDoorVerdictForm, field, name));
  const std::optional<std::int64_t> sequence = ToNumber(ids[2]);
  if (sequence && *sequence >= 1) return DoorVerdictName{SiteId(ids[0]), SessionId(ids[1]), *sequence};
  return InvalidArgument("{} is \"{}\": doors are numbered by records, from 1 on", field, Excerpt(name, 200));
}

absl::StatusOr<RearrangementName> ParseRearrangementName(std::string_view field, std::string_view name) {
  ENFILADE_ASSIGN_OR_RETURN(const auto ids, MatchOrError(kRearrangementForm, field, name));
  return RearrangementName{SiteId(ids[0]), ids[1]};
}

}  // namespace enfilade::convert

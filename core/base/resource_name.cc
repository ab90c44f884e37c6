// SPDX-License-Identifier: Apache-2.0
#include "core/base/resource_name.h"

#include <string_view>

namespace enfilade {
namespace {

constexpr std::string_view kSites = "sites/";

// One allocation per name: responses hold many names.
std::string ChildOf(const SiteId& site, std::string_view collection, const std::string& id) {
  std::string name;
  name.reserve(kSites.size() + site.value().size() + collection.size() + id.size());
  name.append(kSites).append(site.value()).append(collection).append(id);
  return name;
}

}  // namespace

std::string NameOf(const SiteId& site) { return ChildOf(site, "", ""); }
std::string NameOf(const SiteId& site, const RobotId& robot) { return ChildOf(site, "/robots/", robot.value()); }
std::string NameOf(const SiteId& site, const MapId& map) { return ChildOf(site, "/maps/", map.value()); }
std::string NameOf(const SiteId& site, const MapId& map, const MapDraftId& draft) {
  return NameOf(site, map) + "/drafts/" + draft.value();
}
std::string NameOf(const SiteId& site, const MapId& map, const MapAreaId& area) {
  return NameOf(site, map) + "/areas/" + area.value();
}
std::string NameOf(const SiteId& site, const MapId& map, const MapAliasId& alias) {
  return NameOf(site, map) + "/aliases/" + alias.value();
}
std::string NameOf(const SiteId& site, const PriorMapId& prior_map) {
  return ChildOf(site, "/priorMaps/", prior_map.value());
}
std::string NameOf(const SiteId& site, const LinkPointId& link_point) {
  return ChildOf(site, "/linkPoints/", link_point.value());
}
std::string NameOf(const SiteId& site, const SessionId& session) {
  return ChildOf(site, "/sessions/", session.value());
}

}  // namespace enfilade

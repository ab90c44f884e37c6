// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/ids.h"

namespace enfilade {

// Resource names in the API's form (AIP-122), for responses and messages.
std::string NameOf(const SiteId& site);
std::string NameOf(const SiteId& site, const RobotId& robot);
std::string NameOf(const SiteId& site, const MapId& map);
std::string NameOf(const SiteId& site, const MapId& map, const MapDraftId& draft);
std::string NameOf(const SiteId& site, const MapId& map, const MapAreaId& area);
std::string NameOf(const SiteId& site, const MapId& map, const MapAliasId& alias);
std::string NameOf(const SiteId& site, const PriorMapId& prior_map);
std::string NameOf(const SiteId& site, const LinkPointId& link_point);
std::string NameOf(const SiteId& site, const SessionId& session);

}  // namespace enfilade

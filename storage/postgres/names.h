#pragma once

#include <string>

#include "core/base/ids.h"
#include "fmt/format.h"

namespace enfilade::postgres {

// Resource names for messages, as the API has them.
inline std::string NameOf(const SiteId& site) { return fmt::format("sites/{}", site.value()); }
inline std::string NameOf(const SiteId& site, const RobotId& robot) {
  return fmt::format("sites/{}/robots/{}", site.value(), robot.value());
}
inline std::string NameOf(const SiteId& site, const MapId& map) {
  return fmt::format("sites/{}/maps/{}", site.value(), map.value());
}
inline std::string NameOf(const SiteId& site, const LinkPointId& link_point) {
  return fmt::format("sites/{}/linkPoints/{}", site.value(), link_point.value());
}
inline std::string NameOf(const SiteId& site, const SessionId& session) {
  return fmt::format("sites/{}/sessions/{}", site.value(), session.value());
}

}  // namespace enfilade::postgres

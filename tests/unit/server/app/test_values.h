// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/graph/link_point.h"
#include "core/sensor/record.h"
#include "storage/call_context.h"
#include "storage/graph/link_point_store.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/session_store.h"

// Values for the tests of server/app.

namespace enfilade::server {

inline storage::CallContext Soon() { return storage::CallContext::WithTimeout(std::chrono::seconds(60)); }

// At `sequence` seconds, along x.
inline sensor::Record OdometryRecord(std::int64_t sequence) {
  return {sequence, sensor::Odometry{sequence * kNsPerSecond, {0.1 * static_cast<double>(sequence), 0.0, 0.0}}};
}
inline std::vector<sensor::Record> OdometryRecords(std::int64_t first, std::int64_t last) {
  std::vector<sensor::Record> records;
  for (std::int64_t sequence = first; sequence <= last; ++sequence) records.push_back(OdometryRecord(sequence));
  return records;
}

inline storage::Map MakeMap(const SiteId& site, const std::string& id) {
  storage::Map map;
  map.site = site;
  map.id = MapId(id);
  map.display_name = "Room " + id;
  return map;
}

inline storage::Session MakeSession(const SiteId& site, const std::string& id, const std::string& map) {
  storage::Session session;
  session.site = site;
  session.id = SessionId(id);
  session.robot = RobotId("r");
  if (!map.empty()) session.map = MapId(map);
  return session;
}

// Joins two maps: `T_from_place` in the first one, at the origin of the second one.
inline storage::StoredLinkPoint MakeDoor(const SiteId& site, const std::string& id, const std::string& from,
                                         const std::string& to, const Pose2& T_from_place) {
  storage::StoredLinkPoint link_point;
  link_point.site = site;
  link_point.point.id = LinkPointId(id);
  link_point.point.anchors = {{MapId(from), T_from_place, graph::DefaultAnchorCovariance()},
                              {MapId(to), {}, graph::DefaultAnchorCovariance()}};
  return link_point;
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/store_values.h"

#include "core/base/sha256.h"

namespace enfilade::testing {

storage::Site MakeSite(const SiteId& id, const std::string& display_name) {
  storage::Site site;
  site.id = id;
  site.display_name = display_name;
  return site;
}

storage::Robot MakeRobot(const SiteId& site, const RobotId& id, const std::string& display_name) {
  storage::Robot robot;
  robot.site = site;
  robot.id = id;
  robot.display_name = display_name;
  return robot;
}

storage::Map MakeMap(const SiteId& site, const MapId& id, const std::string& display_name) {
  storage::Map map;
  map.site = site;
  map.id = id;
  map.display_name = display_name;
  return map;
}

storage::Session MakeSession(const SiteId& site, const SessionId& id, const RobotId& robot,
                             const std::optional<MapId>& map) {
  storage::Session session;
  session.site = site;
  session.id = id;
  session.robot = robot;
  session.map = map;
  return session;
}

graph::Anchor MakeAnchor(const std::string& map, double x, double y, double yaw) {
  return {MapId(map), {x, y, yaw}, graph::DefaultAnchorCovariance()};
}

storage::StoredLinkPoint MakeLinkPoint(const SiteId& site, const std::string& id,
                                       const std::vector<graph::Anchor>& anchors) {
  storage::StoredLinkPoint link_point;
  link_point.site = site;
  link_point.point.id = LinkPointId(id);
  link_point.point.anchors = anchors;
  return link_point;
}

storage::MappingStep StepOf(const slam::SlamDelta& delta, std::string_view checkpoint, std::int64_t mapped_sequence) {
  return {delta, checkpoint, {}, mapped_sequence, nullptr, {}, std::nullopt, ""};
}

sensor::Record ScanRecord(std::int64_t sequence, std::size_t beams) {
  sensor::LaserScan scan;
  scan.time = sequence * kNsPerSecond;
  scan.angle_min = -1.5;
  scan.angle_increment = 0.01;
  scan.range_max = 30.0F;
  for (std::size_t i = 0; i < beams; ++i) {
    scan.ranges.push_back(static_cast<float>(sequence) + 0.001F * static_cast<float>(i));
  }
  return {sequence, scan};
}

sensor::Record OdometryRecord(std::int64_t sequence) {
  return {sequence, sensor::Odometry{sequence * kNsPerSecond, {0.1 * static_cast<double>(sequence), 1.0 / 3.0, -0.5}}};
}

sensor::Record ImageRecord(std::int64_t sequence, const sensor::BlobRef& content) {
  return {sequence,
          sensor::Image{sequence * kNsPerSecond, sensor::Camera::kRear, sensor::ImageEncoding::kPng, content}};
}

sensor::Record WithheldRecord(std::int64_t sequence) {
  return {sequence, sensor::Withheld{"no beams: ' \" \\ \xc3\xa4"}};
}

std::vector<sensor::Record> ScanRecords(std::int64_t first, std::int64_t last) {
  std::vector<sensor::Record> records;
  for (std::int64_t sequence = first; sequence <= last; ++sequence) records.push_back(ScanRecord(sequence));
  return records;
}

TestBlob::TestBlob(std::string data) : data_(std::move(data)), sha256_(Sha256(data_)) {}

}  // namespace enfilade::testing

#include "tests/contract/storage/store_test.h"

#include "core/base/sha256.h"

namespace enfilade::testing {

StoreTest::StoreTest() {
  EXPECT_OK(sites_.Create(Soon(), MakeSite(site_, "Campus"), ""));
  EXPECT_OK(robots_.Create(Soon(), MakeRobot(site_, robot_, "Robot 1"), ""));
  EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, map_, "Hall"), ""));
}

Site MakeSite(const SiteId& id, const std::string& display_name) {
  Site site;
  site.id = id;
  site.display_name = display_name;
  return site;
}

Robot MakeRobot(const SiteId& site, const RobotId& id, const std::string& display_name) {
  Robot robot;
  robot.site = site;
  robot.id = id;
  robot.display_name = display_name;
  return robot;
}

Map MakeMap(const SiteId& site, const MapId& id, const std::string& display_name) {
  Map map;
  map.site = site;
  map.id = id;
  map.display_name = display_name;
  return map;
}

Session MakeSession(const SiteId& site, const SessionId& id, const RobotId& robot, const std::optional<MapId>& map) {
  Session session;
  session.site = site;
  session.id = id;
  session.robot = robot;
  session.map = map;
  return session;
}

Anchor MakeAnchor(const std::string& map, double x, double y, double yaw) {
  return {MapId(map), {x, y, yaw}, DefaultAnchorCovariance()};
}

StoredLinkPoint MakeLinkPoint(const SiteId& site, const std::string& id, const std::vector<Anchor>& anchors) {
  StoredLinkPoint link_point;
  link_point.site = site;
  link_point.point.id = LinkPointId(id);
  link_point.point.anchors = anchors;
  return link_point;
}

MappingStep StepOf(const SlamDelta& delta, std::string_view checkpoint, std::int64_t mapped_sequence) {
  return {delta, checkpoint, {}, mapped_sequence, nullptr, {}, std::nullopt, ""};
}

SessionId StoreTest::NewSession(const std::string& id, bool mapped) {
  const SessionId session(id);
  EXPECT_OK(sessions_.Create(
      Soon(), MakeSession(site_, session, robot_, mapped ? std::optional<MapId>(map_) : std::nullopt), ""));
  return session;
}

absl::StatusOr<AppendResult> StoreTest::Append(const SessionId& session, const std::vector<Record>& records,
                                               const std::vector<BlobView>& blobs) {
  return records_.Append(Soon(), {site_, session, records, blobs});
}

Record ScanRecord(std::int64_t sequence, std::size_t beams) {
  LaserScan scan;
  scan.time = sequence * kNsPerSecond;
  scan.angle_min = -1.5;
  scan.angle_increment = 0.01;
  scan.range_max = 30.0F;
  for (std::size_t i = 0; i < beams; ++i) {
    scan.ranges.push_back(static_cast<float>(sequence) + 0.001F * static_cast<float>(i));
  }
  return {sequence, scan};
}

Record OdometryRecord(std::int64_t sequence) {
  return {sequence, Odometry{sequence * kNsPerSecond, {0.1 * static_cast<double>(sequence), 1.0 / 3.0, -0.5}}};
}

Record ImageRecord(std::int64_t sequence, const BlobRef& content) {
  return {sequence, Image{sequence * kNsPerSecond, Camera::kRear, ImageEncoding::kPng, content}};
}

Record WithheldRecord(std::int64_t sequence) { return {sequence, Withheld{"no beams: ' \" \\ \xc3\xa4"}}; }

std::vector<Record> ScanRecords(std::int64_t first, std::int64_t last) {
  std::vector<Record> records;
  for (std::int64_t sequence = first; sequence <= last; ++sequence) records.push_back(ScanRecord(sequence));
  return records;
}

TestBlob::TestBlob(std::string data) : data_(std::move(data)), sha256_(Sha256(data_)) {}

}  // namespace enfilade::testing

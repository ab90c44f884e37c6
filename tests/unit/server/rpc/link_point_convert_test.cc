// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "proto/convert/geometry.h"
#include "server/rpc/link_point/convert.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const SiteId kSite("hq");

storage::StoredLinkPoint MakeDoor() {
  storage::StoredLinkPoint door;
  door.site = kSite;
  door.point.id = LinkPointId("door");
  door.point.kind = graph::LinkPointKind::kLift;
  door.point.tag = "behind the stairs";
  door.point.anchors = {{MapId("lobby"), {1, 2, 0.5}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal()},
                        {MapId("lab"), {-3, 4, -0.5}, graph::DefaultAnchorCovariance()}};
  door.point.direction = MapId("lab");
  door.point.difficulty = 2;
  door.point.state = graph::PassageState::kBlocked;
  door.point.state_valid_until = 1'700'000'000'000'000'000;
  door.environment = Environment::kOutdoor;
  return door;
}

TEST(LinkPointMessage, ReadsBackWhatItWrote) {
  const storage::StoredLinkPoint door = MakeDoor();
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint back, FromProto(kSite, ToProto(door)));
  EXPECT_EQ(back.site, door.site);
  EXPECT_EQ(back.point.kind, door.point.kind);
  EXPECT_EQ(back.point.tag, door.point.tag);
  EXPECT_EQ(back.point.anchors, door.point.anchors);
  EXPECT_EQ(back.point.direction, door.point.direction);
  EXPECT_EQ(back.point.difficulty, door.point.difficulty);
  EXPECT_EQ(back.point.state, door.point.state);
  EXPECT_EQ(back.point.state_valid_until, door.point.state_valid_until);
  EXPECT_EQ(back.environment, door.environment);
  EXPECT_TRUE(back.point.id.empty()) << "the name is not read";
}

TEST(LinkPointMessage, HasAPlaceInTheWorldOnlyIfItIsKnown) {
  storage::StoredLinkPoint door = MakeDoor();
  EXPECT_FALSE(ToProto(door).has_pose_world_place());
  door.T_world_place = PoseWithCovariance{{10, 20, 0}, Eigen::Matrix3d::Identity()};
  door.etag = 5;
  door.forced = true;
  door.point.graph_version = 44;
  door.point.use = graph::LinkPointUse::kSwitchedOff;
  const v1::LinkPoint out = ToProto(door);
  EXPECT_EQ(out.name(), "sites/hq/linkPoints/door");
  EXPECT_EQ(out.pose_world_place().pose().y(), 20);
  EXPECT_EQ(out.etag(), "5");
  EXPECT_TRUE(out.forced());
  EXPECT_EQ(out.graph_version(), 44);
  EXPECT_EQ(out.use(), v1::LinkPoint::USE_SWITCHED_OFF);
  EXPECT_EQ(out.direction_map(), "sites/hq/maps/lab");
}

TEST(LinkPointMessage, HasDefaultsForWhatIsUnset) {
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint read, FromProto(kSite, v1::LinkPoint()));
  EXPECT_EQ(read.point.kind, graph::LinkPointKind::kDoor);
  EXPECT_EQ(read.point.state, graph::PassageState::kOpen);
  EXPECT_FALSE(read.environment.has_value());
  EXPECT_FALSE(read.point.state_valid_until.has_value());
  EXPECT_TRUE(read.point.direction.empty());
}

TEST(LinkPointMessage, WhatPeopleMakeOrPlaceIsPinnedUnlessTheySayOtherwise) {
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint made, FromProto(kSite, v1::LinkPoint()));
  EXPECT_TRUE(made.point.pinned);
  v1::LinkPoint unpinned;
  unpinned.set_pinned(false);
  ASSERT_OK_AND_ASSIGN(made, FromProto(kSite, unpinned));
  EXPECT_FALSE(made.point.pinned);

  const v1::LinkPoint stored = ToProto(MakeDoor());  // a survey's
  ASSERT_FALSE(stored.pinned());
  const auto updated = [&](v1::LinkPoint from, const std::vector<std::string>& paths) {
    google::protobuf::FieldMask mask;
    for (const std::string& path : paths) mask.add_paths(path);
    v1::LinkPoint to = stored;
    Overwrite(from, mask, to);
    return to.pinned();
  };
  EXPECT_TRUE(updated(stored, {"anchors"})) << "as it was read, and written back with other anchors";
  EXPECT_TRUE(updated(stored, {"kind"}));
  EXPECT_TRUE(updated(stored, {"direction_map"}));
  EXPECT_TRUE(updated(stored, {}));
  EXPECT_FALSE(updated(stored, {"tag", "state", "difficulty"}));
  EXPECT_FALSE(updated(unpinned, {"pinned"}));
  EXPECT_FALSE(updated(stored, {"anchors", "pinned"}));
  EXPECT_FALSE(updated(unpinned, {}));
}

TEST(LinkPointMessage, GivesAnAnchorWithoutCovarianceTheDefaultOne) {
  v1::Anchor anchor;
  anchor.set_map("sites/hq/maps/lobby");
  anchor.mutable_pose_map_place()->mutable_pose()->set_x(1);
  ASSERT_OK_AND_ASSIGN(graph::Anchor read, FromProto("anchor", kSite, anchor));
  EXPECT_EQ(read.covariance, graph::DefaultAnchorCovariance());
  convert::SetMatrix(Eigen::Matrix3d::Zero(), anchor.mutable_pose_map_place()->mutable_covariance());
  ASSERT_OK_AND_ASSIGN(read, FromProto("anchor", kSite, anchor));
  EXPECT_EQ(read.covariance, Eigen::Matrix3d::Zero()) << "exactly known is not unknown";
}

TEST(LinkPointMessage, RefusesWhatItCannotHoldNamingTheField) {
  struct Case {
    const char* field;
    void (*change)(v1::LinkPoint&);
  };
  const Case cases[] = {
      {"link_point.kind is 99", [](v1::LinkPoint& p) { p.set_kind(static_cast<v1::LinkPoint::Kind>(99)); }},
      {"link_point.state is 99", [](v1::LinkPoint& p) { p.set_state(static_cast<v1::LinkPoint::State>(99)); }},
      {"link_point.environment is 99",
       [](v1::LinkPoint& p) { p.set_environment(static_cast<v1::Map::Environment>(99)); }},
      {"link_point.tag", [](v1::LinkPoint& p) { p.set_tag(std::string(201, 'x')); }},
      {"link_point.tag", [](v1::LinkPoint& p) { p.set_tag(std::string("a\0b", 3)); }},
      {"link_point.difficulty is -1", [](v1::LinkPoint& p) { p.set_difficulty(-1); }},
      {"link_point.anchors[1].map", [](v1::LinkPoint& p) { p.mutable_anchors(1)->set_map("maps/lab"); }},
      {"link_point.anchors[0].map", [](v1::LinkPoint& p) { p.mutable_anchors(0)->set_map("sites/x/maps/m"); }},
      {"link_point.anchors[0].pose_map_place", [](v1::LinkPoint& p) { p.mutable_anchors(0)->clear_pose_map_place(); }},
      {"link_point.direction_map", [](v1::LinkPoint& p) { p.set_direction_map("sites/x/maps/lab"); }},
  };
  for (const Case& test : cases) {
    v1::LinkPoint message = ToProto(MakeDoor());
    test.change(message);
    EXPECT_STATUS(FromProto(kSite, message), absl::StatusCode::kInvalidArgument, HasSubstr(test.field)) << test.field;
  }
  v1::LinkPoint longest = ToProto(MakeDoor());
  longest.set_tag(std::string(200, 'x'));
  EXPECT_OK(FromProto(kSite, longest));
}

TEST(MapOfSite, NamesBothSitesIfTheyDiffer) {
  EXPECT_EQ(*MapOfSite("map", kSite, "sites/hq/maps/lobby"), MapId("lobby"));
  EXPECT_STATUS(MapOfSite("map", kSite, "sites/branch/maps/lobby"), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("map"), HasSubstr("\"branch\""), HasSubstr("\"hq\"")));
}

TEST(CandidatesOf, TellsCandidatesFromLinkPoints) {
  EXPECT_EQ(*CandidatesOf(v1::LINK_POINT_SUBSET_UNSPECIFIED), std::nullopt);
  EXPECT_EQ(*CandidatesOf(v1::LINK_POINT_SUBSET_CANDIDATES), std::optional(true));
  EXPECT_EQ(*CandidatesOf(v1::LINK_POINT_SUBSET_LINK_POINTS), std::optional(false));
  EXPECT_STATUS(CandidatesOf(static_cast<v1::LinkPointSubset>(99)), absl::StatusCode::kInvalidArgument,
                HasSubstr("subset is 99"));
}

storage::Evidence MakeEvidence(storage::EvidenceKind kind, std::int16_t encoding) {
  storage::Evidence evidence;
  evidence.link_point = LinkPointId("door");
  evidence.map = MapId("lobby");
  evidence.kind = kind;
  evidence.encoding = encoding;
  evidence.content = {std::string(32, '\x05'), 1234};
  evidence.time = 1'700'000'000'000'000'000;
  return evidence;
}

TEST(EvidenceMessage, ReadsBackEachKind) {
  for (const auto& evidence :
       {MakeEvidence(storage::EvidenceKind::kFrontImage, static_cast<std::int16_t>(sensor::ImageEncoding::kJpeg)),
        MakeEvidence(storage::EvidenceKind::kRearImage, static_cast<std::int16_t>(sensor::ImageEncoding::kPng)),
        MakeEvidence(storage::EvidenceKind::kCloud, static_cast<std::int16_t>(sensor::CloudEncoding::kXyz32))}) {
    const v1::Evidence message = ToProto(kSite, evidence);
    EXPECT_EQ(message.map(), "sites/hq/maps/lobby");
    EXPECT_EQ(message.has_cloud(), evidence.kind == storage::EvidenceKind::kCloud);
    ASSERT_OK_AND_ASSIGN(const storage::Evidence back, FromProto({kSite, LinkPointId("door")}, message));
    EXPECT_EQ(back.link_point, evidence.link_point);
    EXPECT_EQ(back.map, evidence.map);
    EXPECT_EQ(back.kind, evidence.kind);
    EXPECT_EQ(back.encoding, evidence.encoding);
    EXPECT_EQ(back.content, evidence.content);
    EXPECT_EQ(back.time, evidence.time);
  }
}

TEST(EvidenceMessage, FollowsTheRulesOfARecordsImage) {
  v1::Evidence message = ToProto(kSite, MakeEvidence(storage::EvidenceKind::kFrontImage, 1));
  message.mutable_image()->mutable_content()->set_sha256("short");
  EXPECT_STATUS(FromProto({kSite, LinkPointId("door")}, message), absl::StatusCode::kInvalidArgument,
                HasSubstr("sha256"));
  message.clear_image();
  EXPECT_STATUS(FromProto({kSite, LinkPointId("door")}, message), absl::StatusCode::kInvalidArgument,
                HasSubstr("expected image or cloud"));
  message = ToProto(kSite, MakeEvidence(storage::EvidenceKind::kFrontImage, 1));
  message.set_map("sites/branch/maps/lobby");
  EXPECT_STATUS(FromProto({kSite, LinkPointId("door")}, message), absl::StatusCode::kInvalidArgument,
                HasSubstr("evidence.map"));
}

}  // namespace
}  // namespace enfilade::server

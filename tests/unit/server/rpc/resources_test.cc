// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/resources.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(SiteResource, HasNameEtagAndRetentionOnlyIfSet) {
  storage::Site site{.id = SiteId("hq"), .display_name = "Head office", .raw_retention = {}, .etag = 17};
  site.create_time = 1'700'000'000'000'000'005;
  v1::Site out = ToProto(site);
  EXPECT_EQ(out.name(), "sites/hq");
  EXPECT_EQ(out.display_name(), "Head office");
  EXPECT_EQ(out.etag(), "17");
  EXPECT_EQ(out.create_time().seconds(), 1'700'000'000);
  EXPECT_EQ(out.create_time().nanos(), 5);
  EXPECT_FALSE(out.has_raw_retention()) << "records are kept for ever";
  site.raw_retention = std::chrono::seconds(0);
  out = ToProto(site);
  EXPECT_TRUE(out.has_raw_retention()) << "0 s is not for ever";
  EXPECT_EQ(out.raw_retention().seconds(), 0);
}

TEST(SiteResource, ReadsBackWhatItWrote) {
  for (const auto retention : {std::optional<std::chrono::seconds>(), std::optional(std::chrono::seconds(0)),
                               std::optional(std::chrono::seconds(86'400))}) {
    storage::Site site;
    site.id = SiteId("hq");
    site.display_name = "B\xC3\xBCro";
    site.raw_retention = retention;
    ASSERT_OK_AND_ASSIGN(const storage::Site back, FromProto(ToProto(site)));
    EXPECT_EQ(back.display_name, site.display_name);
    EXPECT_EQ(back.raw_retention, retention);
    EXPECT_TRUE(back.id.empty()) << "the name is not read";
    EXPECT_EQ(back.etag, 0);
  }
}

TEST(SiteResource, EachRetentionIsReadBackByItself) {
  using std::chrono::seconds;
  for (const auto retention : {&storage::Site::raw_retention, &storage::Site::session_retention,
                               &storage::Site::history_retention, &storage::Site::audit_retention}) {
    storage::Site site;
    site.display_name = "Site";
    site.*retention = seconds(7);
    ASSERT_OK_AND_ASSIGN(const storage::Site back, FromProto(ToProto(site)));
    for (const auto other : {&storage::Site::raw_retention, &storage::Site::session_retention,
                             &storage::Site::history_retention, &storage::Site::audit_retention}) {
      EXPECT_EQ(back.*other, site.*other);
    }
    EXPECT_FALSE(back.revision_retention);
  }
}

TEST(RevisionTag, HasAtMost64Characters) {
  std::string umlauts;
  for (int i = 0; i < 64; ++i) umlauts += "\xC3\xBC";
  EXPECT_OK(CheckTag("tag", umlauts));
  EXPECT_OK(CheckTag("tag", ""));
  EXPECT_STATUS(CheckTag("tag", umlauts + "x"), absl::StatusCode::kInvalidArgument, HasSubstr("tag"));
  EXPECT_CODE(CheckTag("tag", std::string("a\0b", 3)), absl::StatusCode::kInvalidArgument);
}

TEST(SiteResource, RefusesARetentionThatIsNoWholeNumberOfSeconds) {
  v1::Site site;
  site.set_display_name("Site");
  site.mutable_raw_retention()->set_seconds(-1);
  EXPECT_STATUS(FromProto(site), absl::StatusCode::kInvalidArgument, HasSubstr("site.raw_retention"));
  site.mutable_raw_retention()->set_seconds(1'000'000'000'000);
  EXPECT_STATUS(FromProto(site), absl::StatusCode::kInvalidArgument, HasSubstr("3153600000"));
  site.mutable_raw_retention()->set_seconds(1);
  site.mutable_raw_retention()->set_nanos(1);
  EXPECT_STATUS(FromProto(site), absl::StatusCode::kInvalidArgument, HasSubstr("site.raw_retention"));
}

// Every resource that has one, by one rule: 1 to 200 characters, not bytes.
TEST(DisplayName, IsCountedInCharacters) {
  std::string umlauts;
  for (int i = 0; i < 200; ++i) umlauts += "\xC3\xBC";
  struct Case {
    std::string name;
    bool valid;
  };
  for (const Case& test :
       {Case{"x", true}, Case{std::string(200, 'x'), true}, Case{umlauts, true}, Case{"", false},
        Case{std::string(201, 'x'), false}, Case{umlauts + "x", false}, Case{std::string("a\0b", 3), false}}) {
    v1::Site site;
    v1::Robot robot;
    v1::Map map;
    site.set_display_name(test.name);
    robot.set_display_name(test.name);
    map.set_display_name(test.name);
    EXPECT_EQ(FromProto(site).ok(), test.valid) << test.name.size();
    EXPECT_EQ(FromProto(robot).ok(), test.valid) << test.name.size();
    EXPECT_EQ(FromProto(map).ok(), test.valid) << test.name.size();
  }
  EXPECT_STATUS(FromProto(v1::Robot()), absl::StatusCode::kInvalidArgument, HasSubstr("robot.display_name"));
  EXPECT_STATUS(FromProto(v1::Map()), absl::StatusCode::kInvalidArgument, HasSubstr("map.display_name"));
}

storage::Map MakeMap() {
  storage::Map map;
  map.site = SiteId("hq");
  map.id = MapId("lobby");
  map.display_name = "Lobby";
  map.level = -2;
  map.environment = Environment::kOutdoor;
  map.slam_profile = "garden";
  map.outline = {{0, 0}, {4.5, 0}, {4.5, 3}};
  map.etag = 3;
  return map;
}

TEST(MapResource, ReadsBackWhatItWrote) {
  const storage::Map map = MakeMap();
  const v1::Map out = ToProto(map);
  EXPECT_EQ(out.name(), "sites/hq/maps/lobby");
  ASSERT_OK_AND_ASSIGN(const storage::Map back, FromProto(out));
  EXPECT_EQ(back.display_name, map.display_name);
  EXPECT_EQ(back.level, map.level);
  EXPECT_EQ(back.environment, map.environment);
  EXPECT_EQ(back.slam_profile, map.slam_profile);
  EXPECT_EQ(back.outline, map.outline);
}

TEST(MapResource, NamesItsLatestRevisionOnceThereIsOne) {
  storage::Map map = MakeMap();
  EXPECT_EQ(ToProto(map).latest_revision(), "");
  map.current_revision = 12;
  EXPECT_EQ(ToProto(map).latest_revision(), "sites/hq/maps/lobby/revisions/12");
}

TEST(MapResource, IsIndoorUnlessToldOtherwiseAndRefusesUnknownEnvironments) {
  v1::Map map;
  map.set_display_name("Lobby");
  EXPECT_EQ(FromProto(map)->environment, Environment::kIndoor);
  map.set_environment(v1::Map::ENVIRONMENT_INDOOR);
  EXPECT_EQ(FromProto(map)->environment, Environment::kIndoor);
  map.set_environment(v1::Map::ENVIRONMENT_OUTDOOR);
  EXPECT_EQ(FromProto(map)->environment, Environment::kOutdoor);
  map.set_environment(static_cast<v1::Map::Environment>(77));
  EXPECT_STATUS(FromProto(map), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("map.environment"), HasSubstr("77")));
}

TEST(RevisionResource, NamesSourceSessionAndGrid) {
  storage::MapRevision revision;
  revision.site = SiteId("hq");
  revision.map = MapId("lobby");
  revision.number = 4;
  revision.geometry.resolution = 0.05;
  revision.geometry.width = 30;
  revision.geometry.height = 20;
  revision.geometry.T_map_grid = {-1.5, 2.0, 0.25};
  revision.content_sha256 = std::string(32, '\x7f');
  v1::MapRevision out = ToProto(revision);
  EXPECT_EQ(out.name(), "sites/hq/maps/lobby/revisions/4");
  EXPECT_EQ(out.source(), v1::MapRevision::SOURCE_MAPPING);
  EXPECT_EQ(out.session(), "");
  EXPECT_EQ(out.resolution_m(), 0.05);
  EXPECT_EQ(out.width(), 30);
  EXPECT_EQ(out.height(), 20);
  EXPECT_EQ(out.pose_map_grid().x(), -1.5);
  EXPECT_EQ(out.pose_map_grid().y(), 2.0);
  EXPECT_EQ(out.pose_map_grid().yaw(), 0.25);
  EXPECT_EQ(out.content_sha256(), revision.content_sha256);
  revision.source = storage::RevisionSource::kImport;
  revision.session = SessionId("monday");
  out = ToProto(revision);
  EXPECT_EQ(out.source(), v1::MapRevision::SOURCE_IMPORT);
  EXPECT_EQ(out.session(), "sites/hq/sessions/monday");
}

TEST(SessionResource, CountsEachKindInItsOwnField) {
  storage::Session session;
  session.site = SiteId("hq");
  session.id = SessionId("monday");
  session.robot = RobotId("r1");
  session.state = storage::SessionState::kMapped;
  session.acknowledged_sequence = 100;
  session.mapped_sequence = 90;
  session.record_counts = {
      .laser_scans = 1, .odometry = 2, .images = 3, .point_clouds = 4, .withheld = 5, .door_reports = 6};
  session.mapping_counts = {.paired = 11, .unpaired = 12, .time_reversed = 13, .used = 14, .keyframes = 15, .lost = 16};
  session.error = "no scans";
  const v1::Session out = ToProto(session);
  EXPECT_EQ(out.name(), "sites/hq/sessions/monday");
  EXPECT_EQ(out.robot(), "sites/hq/robots/r1");
  EXPECT_EQ(out.state(), v1::Session::STATE_MAPPED);
  EXPECT_EQ(out.acknowledged_sequence(), 100);
  EXPECT_EQ(out.mapped_sequence(), 90);
  const v1::RecordCounts& records = out.record_counts();
  EXPECT_THAT((std::vector<std::int64_t>{records.laser_scans(), records.odometries(), records.images(),
                                         records.point_clouds(), records.withheld(), records.door_reports()}),
              ElementsAre(1, 2, 3, 4, 5, 6));
  const v1::MappingCounts& mapping = out.mapping_counts();
  EXPECT_THAT((std::vector<std::int64_t>{mapping.paired(), mapping.unpaired(), mapping.time_reversed(), mapping.used(),
                                         mapping.keyframes(), mapping.lost()}),
              ElementsAre(11, 12, 13, 14, 15, 16));
  EXPECT_EQ(out.error(), "no scans");
  EXPECT_FALSE(out.has_entry());
  EXPECT_FALSE(out.has_finish_time());
  EXPECT_EQ(out.map(), "") << "only recorded";
}

TEST(SessionResource, ShowsHowItEnteredItsMap) {
  storage::Session session;
  session.site = SiteId("hq");
  session.id = SessionId("tuesday");
  session.robot = RobotId("r1");
  session.map = MapId("lobby");
  session.finish_time = 1'700'000'000'000'000'000;
  session.entry.previous = SessionId("monday");
  session.entry.T_map_robot = PoseWithCovariance{{1, 2, 0.5}, Eigen::Matrix3d::Identity()};
  session.entry.T_odom_robot = Pose2{7, 8, 9};
  const v1::Session out = ToProto(session);
  EXPECT_EQ(out.map(), "sites/hq/maps/lobby");
  EXPECT_EQ(out.finish_time().seconds(), 1'700'000'000);
  EXPECT_EQ(out.entry().previous_session(), "sites/hq/sessions/monday");
  EXPECT_EQ(out.entry().pose_map_robot().pose().x(), 1);
  EXPECT_EQ(out.entry().pose_map_robot().covariance_size(), 9);
  EXPECT_EQ(out.entry().pose_odom_robot().yaw(), 9);
}

TEST(ClosureResource, IsALoopClosureOfItsSession) {
  slam::LoopClosure closure;
  closure.id = 8;
  closure.submap = 2;
  closure.node = 30;
  closure.T_submap_node = {1, 2, 3};
  closure.score = 0.75;
  closure.chi2 = 2.5;
  closure.reason = "accepted";
  for (const auto& [state, expected] : {std::pair{slam::LoopClosureState::kAccepted, v1::Closure::STATE_ACCEPTED},
                                        std::pair{slam::LoopClosureState::kRejected, v1::Closure::STATE_REJECTED},
                                        std::pair{slam::LoopClosureState::kSuspended, v1::Closure::STATE_SUSPENDED}}) {
    closure.state = state;
    const v1::Closure out = ToProto({SiteId("hq"), SessionId("monday")}, closure);
    EXPECT_EQ(out.name(), "sites/hq/sessions/monday/closures/8");
    EXPECT_EQ(out.state(), expected);
    EXPECT_EQ(out.submap(), 2);
    EXPECT_EQ(out.node(), 30);
    EXPECT_EQ(out.pose_submap_node().yaw(), 3);
    EXPECT_EQ(out.score(), 0.75);
    EXPECT_EQ(out.chi2(), 2.5);
    EXPECT_EQ(out.reason(), "accepted");
  }
}

TEST(Etag, IsAPositiveNumberOrEmpty) {
  EXPECT_EQ(*ParseEtag(""), 0) << "any";
  EXPECT_EQ(*ParseEtag("1"), 1);
  EXPECT_EQ(*ParseEtag("9223372036854775807"), std::numeric_limits<std::int64_t>::max());
  for (const char* etag : {"0", "-1", "1x", "x", " 1", "1 ", "9223372036854775808", "1.0", "+1", "0x1"}) {
    EXPECT_STATUS(ParseEtag(etag), absl::StatusCode::kInvalidArgument, HasSubstr("etag")) << etag;
  }
  EXPECT_LT(std::string(ParseEtag(std::string(10'000, 'x')).status().message()).size(), 200U);
}

TEST(IdOrNew, TakesAValidIdAndMakesOneIfNoneIsGiven) {
  for (const std::string id : {"a", "0", "a-b", "550e8400-e29b-41d4-a716-446655440000"}) {
    EXPECT_EQ(*IdOrNew("site_id", id), id);
  }
  ASSERT_OK_AND_ASSIGN(const std::string first, IdOrNew("site_id", ""));
  ASSERT_OK_AND_ASSIGN(const std::string second, IdOrNew("site_id", ""));
  EXPECT_NE(first, second);
  EXPECT_EQ(*IdOrNew("site_id", first), first) << "a new id is valid";
  for (const std::string& id : {std::string("A"), std::string("-a"), std::string("a-"), std::string("a_b"),
                                std::string("a/b"), std::string("\xC3\xBC"), std::string(64, 'a')}) {
    EXPECT_STATUS(IdOrNew("site_id", id), absl::StatusCode::kInvalidArgument, HasSubstr("site_id")) << id;
  }
}

TEST(UpdateMask, DecidesWhatIsWritten) {
  google::protobuf::FieldMask mask;
  EXPECT_OK(CheckMask(mask, {"level"}));
  EXPECT_TRUE(IsUpdated(mask, "level", true)) << "without a mask: what is set";
  EXPECT_FALSE(IsUpdated(mask, "level", false));
  mask.add_paths("level");
  EXPECT_OK(CheckMask(mask, {"display_name", "level"}));
  EXPECT_TRUE(IsUpdated(mask, "level", false)) << "to the default";
  EXPECT_FALSE(IsUpdated(mask, "display_name", true)) << "set, but not in the mask";
}

TEST(UpdateMask, NamesWhatCannotBeUpdatedAndWhatCan) {
  google::protobuf::FieldMask mask;
  mask.add_paths("level");
  mask.add_paths("etag");
  EXPECT_STATUS(CheckMask(mask, {"display_name", "level"}), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("\"etag\""), HasSubstr("display_name, level")));
  google::protobuf::FieldMask nested;
  nested.add_paths("level.x");
  EXPECT_FALSE(CheckMask(nested, {"level"}).ok());
}

}  // namespace
}  // namespace enfilade::server

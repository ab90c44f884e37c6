// SPDX-License-Identifier: Apache-2.0
#include "server/app/rearrange/map_rearrangements.h"

#include <functional>
#include <thread>

#include "tests/unit/server/app/rearrange/rearranged_campus.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A hall (the root) and a lab behind a door, each with two sessions; a yard behind the lab; an attic above.
class MapRearrangementsTest : public RearrangedCampus {
 protected:
  MapRearrangementsTest() {
    for (const char* map : {"hall", "lab", "yard"}) AddMap(map);
    AddMap("attic", 1);
    Join("door", "hall", {5, 0, 0}, "lab", {0, 0, 0});
    Join("gate", "lab", {5, 0, 0}, "yard", {0, 0, 0});
    AddMapped("h1", "hall", {1, 0, 0});
    AddMapped("h2", "hall", {2, 0, 0});
    AddMapped("l1", "lab", {1, 1, 0});
    AddMapped("l2", "lab", {3, 1, 0});
    Remember();
  }

  // Refused with the code and text; nothing has changed, and no watcher is told.
  void ExpectRefused(const absl::Status& status, absl::StatusCode code, const std::string& text) {
    EXPECT_STATUS(status, code, HasSubstr(text));
    EXPECT_EQ(Version(), version_) << text;
    EXPECT_THAT(*stores_.rearrangements.List(Soon(), site_, 0, 10), SizeIs(made_)) << text;
  }
  // What ExpectRefused compares with.
  void Remember() {
    version_ = Version();
    made_ = stores_.rearrangements.List(Soon(), site_, 0, 10)->size();
  }

  const SessionId h1_{"h1"}, l1_{"l1"}, l2_{"l2"};
  std::int64_t version_ = 0;
  std::size_t made_ = 0;
};

TEST_F(MapRearrangementsTest, MergesByTheGraph) {
  const Pose2 world = WorldPoseOf(l1_);
  ASSERT_OK_AND_ASSIGN(const auto merged, Merge("hall", "lab"));
  EXPECT_EQ(merged.version_after, version_ + 1);
  EXPECT_EQ(MapOf(l1_).value(), "hall");
  EXPECT_THAT(WorldPoseOf(l1_), testing::PoseNear(world, 1e-12, 1e-12));
  ASSERT_OK_AND_ASSIGN(const auto graph, graphs_.Get(Soon(), site_));
  EXPECT_EQ(graph->graph().version(), merged.version_after) << "this server's next answer has it";
}

TEST_F(MapRearrangementsTest, RefusesAMapWithItself) {
  ExpectRefused(Merge("hall", "hall").status(), absl::StatusCode::kInvalidArgument, "with itself");
}

TEST_F(MapRearrangementsTest, RefusesMapsOfTwoLevels) {
  ExpectRefused(Merge("hall", "attic", Pose2{}).status(), absl::StatusCode::kInvalidArgument, "level");
}

TEST_F(MapRearrangementsTest, RefusesWithoutASurePose) {
  AddMap("shed");
  Remember();
  ExpectRefused(Merge("hall", "shed").status(), absl::StatusCode::kFailedPrecondition, "no link points lead");
  Join("vague", "hall", {0, 5, 0}, "shed", {}, 1000.0);
  Remember();
  ExpectRefused(Merge("hall", "shed").status(), absl::StatusCode::kFailedPrecondition, "sure");
  EXPECT_OK(Merge("hall", "shed", Pose2{0, 5, 0})) << "unless a person gives it";
}

TEST_F(MapRearrangementsTest, RefusesWhatIsRecordedOrMapped) {
  ASSERT_OK(stores_.sessions.Create(Soon(), MakeSession(site_, "recording", "lab"), ""));
  ExpectRefused(Merge("hall", "lab").status(), absl::StatusCode::kFailedPrecondition, "recording");
  ExpectRefused(Split("lab", {SessionId("recording")}, "new").status(), absl::StatusCode::kFailedPrecondition,
                "recording");
  ASSERT_OK(stores_.sessions.Delete(Soon(), site_, SessionId("recording")));
  Record("waiting", "lab");
  ExpectRefused(Merge("hall", "lab").status(), absl::StatusCode::kFailedPrecondition, "waiting");
  EXPECT_OK(Split("lab", {l1_}, "new")) << "what stays may be mapped meanwhile";
}

TEST_F(MapRearrangementsTest, RefusesWhatDividesNothing) {
  ExpectRefused(Split("lab", {}, "new").status(), absl::StatusCode::kFailedPrecondition, "no session leaves");
  ExpectRefused(Split("lab", {l1_, l2_}, "new").status(), absl::StatusCode::kFailedPrecondition, "lab");
  ExpectRefused(Split("lab", {h1_}, "new").status(), absl::StatusCode::kNotFound, "h1");
  for (const std::int64_t sequence : {1, 5}) {
    const absl::Status cut = Split("lab", {}, "new", {{l1_, sequence, SessionId("rest")}}).status();
    EXPECT_THAT(cut.code(),
                ::testing::AnyOf(absl::StatusCode::kFailedPrecondition, absl::StatusCode::kInvalidArgument));
    ExpectRefused(cut, cut.code(), "l1");
  }
  ExpectRefused(Split("lab", {l1_}, "yard").status(), absl::StatusCode::kAlreadyExists, "yard");
}

TEST_F(MapRearrangementsTest, RefusesAMapThatIsGone) {
  ASSERT_OK(Merge("hall", "lab"));
  Remember();
  ExpectRefused(Merge("hall", "lab").status(), absl::StatusCode::kFailedPrecondition,
                "maps/lab was merged into sites/campus/maps/hall already");
  ExpectRefused(Split("lab", {l1_}, "new").status(), absl::StatusCode::kFailedPrecondition, "already");
  ExpectRefused(Merge("hall", "none").status(), absl::StatusCode::kNotFound, "none");
}

TEST_F(MapRearrangementsTest, RefusesToUndoTwiceOrAfterLaterEdits) {
  ASSERT_OK_AND_ASSIGN(const auto first, Merge("hall", "lab"));
  ASSERT_OK(Undo(first.id));
  Remember();
  ExpectRefused(Undo(first.id).status(), absl::StatusCode::kFailedPrecondition, "has been undone already");
  ASSERT_OK_AND_ASSIGN(const auto second, Merge("hall", "lab"));
  ASSERT_OK(stores_.link_points.Delete(Soon(), site_, LinkPointId("gate"), 0));
  Remember();
  ExpectRefused(Undo(second.id).status(), absl::StatusCode::kFailedPrecondition, "link point gate has been changed");
  EXPECT_EQ(MapOf(l1_).value(), "hall") << "nothing is undone";
  ExpectRefused(Undo(rearrange::RearrangementId("none")).status(), absl::StatusCode::kNotFound, "none");
}

// Runs both at the same time.
std::pair<absl::Status, absl::Status> AtOnce(const std::function<absl::Status()>& a,
                                             const std::function<absl::Status()>& b) {
  absl::Status first;
  std::thread other([&] { first = a(); });
  absl::Status second = b();
  other.join();
  return {first, second};
}

TEST_F(MapRearrangementsTest, OfTwoMergesOfTheSameMapsAtOnceOneIsMade) {
  for (int round = 0; round < 20; ++round) {
    const auto [a, b] =
        AtOnce([&] { return Merge("hall", "lab").status(); }, [&] { return Merge("lab", "hall").status(); });
    ASSERT_NE(a.ok(), b.ok()) << a << b;
    EXPECT_STATUS(a.ok() ? b : a, absl::StatusCode::kFailedPrecondition, HasSubstr("already"));
    ASSERT_OK_AND_ASSIGN(const auto made, stores_.rearrangements.List(Soon(), site_, 0, 1));
    ASSERT_OK(Undo(made[0].id));
  }
  EXPECT_EQ(Version(), version_ + 2 * 20) << "one version for each that was made or undone";
}

TEST_F(MapRearrangementsTest, OfTwoThatMeetInOneMapTheOtherIsDecidedAgain) {
  const Pose2 world = WorldPoseOf(l1_);
  for (int round = 0; round < 20; ++round) {
    const auto [a, b] =
        AtOnce([&] { return Merge("hall", "lab").status(); }, [&] { return Merge("lab", "yard").status(); });
    // lab is gone if hall took it first.
    EXPECT_TRUE(a.ok()) << a;
    EXPECT_TRUE(b.ok() || absl::IsFailedPrecondition(b)) << b;
    EXPECT_THAT(WorldPoseOf(l1_), testing::PoseNear(world, 1e-9, 1e-9));
    ASSERT_OK_AND_ASSIGN(const auto made, stores_.rearrangements.List(Soon(), site_, 0, b.ok() ? 2 : 1));
    for (const auto& rearrangement : made) ASSERT_OK(Undo(rearrangement.id));
    EXPECT_EQ(MapOf(l1_).value(), "lab");
  }
}

}  // namespace
}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/known_scans.h"

#include <gmock/gmock.h>

#include "server/app/graph/site_graph_reader.h"
#include "tests/contract/closure/door_closures_fixture.h"

namespace enfilade::testing {
namespace {

// Two rooms that a robot has mapped; nothing works on them any more.
class KnownScansTest : public DoorClosuresTest {
 protected:
  void SetUp() override {
    DoorDriveOptions drive;  // without images and clouds
    drive.campus = TwoRooms();
    drive.robot = "r";
    MapAll(DriveThroughDoors(drive));
    workers_.reset();
  }

  server::KnownScans ReadInto(server::SeenGrounds& grounds, const Pose2& predicted) {
    const auto graph = server::ReadSiteGraph(graph_, Soon(), site_, nullptr);
    EXPECT_OK(graph);
    const server::KnownScansScope scope{
        .stores = stores_, .site = site_, .graph = (*graph)->graph(), .options = options_, .grounds = grounds};
    const auto known =
        server::ReadKnownScans(scope, map_, {predicted, Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal()});
    EXPECT_OK(known);
    return known.value_or(server::KnownScans());
  }

  const storage::FeatureStore features_{*pool_};
  const storage::postgres::SiteLeaseStore leases_{*pool_, storage::SiteRight::kChange};
  const server::DoorClosureStores stores_{sessions_, records_,     mapping_,  blobs_, features_,
                                          maps_,     link_points_, verdicts_, leases_};
};

TEST_F(KnownScansTest, AGroundIsMadeOnceWhereverTheRobotIsPredicted) {
  server::SeenGrounds grounds(100 << 20);
  const auto first = ReadInto(grounds, {1.0, 0.5, 0.0});
  ASSERT_NE(first.ground, nullptr);
  EXPECT_GT(first.ground->viewpoints.size(), 5U);
  EXPECT_EQ(ReadInto(grounds, {0.5, 1.0, 2.0}).ground, first.ground);
}

TEST_F(KnownScansTest, AGroundIsMadeAnewWhenAnythingOfItHasChanged) {
  server::SeenGrounds grounds(100 << 20);
  auto before = ReadInto(grounds, {}).ground;
  const auto expect_fresh = [&](const char* what) {
    const auto after = ReadInto(grounds, {}).ground;
    ASSERT_NE(after, nullptr);
    EXPECT_NE(after, before) << what;
    server::SeenGrounds none(0);
    const auto fresh = ReadInto(none, {}).ground;
    ASSERT_EQ(after->viewpoints.size(), fresh->viewpoints.size()) << what;
    EXPECT_TRUE(after->submap.grid == fresh->submap.grid) << what;
    for (std::size_t i = 0; i < fresh->viewpoints.size(); ++i) {
      EXPECT_EQ(after->viewpoints[i].pose, fresh->viewpoints[i].pose) << what;
      EXPECT_EQ(after->viewpoints[i].covariance, fresh->viewpoints[i].covariance) << what;
    }
    before = after;
  };
  database_.Sql("UPDATE enfilade.slam_nodes SET x = x + 0.1");
  expect_fresh("the scans were taken elsewhere");
  database_.Sql("UPDATE enfilade.slam_nodes SET covariance[1] = 2 * covariance[1]");
  expect_fresh("their places are less certain");
  database_.Sql("SET session_replication_role = replica; DELETE FROM enfilade.slam_nodes WHERE node_id = 3");
  expect_fresh("there is one scan less");
  ASSERT_OK_AND_ASSIGN(const auto doors, link_points_.List(Soon(), site_, {}, {}));
  ASSERT_FALSE(doors.empty());
  storage::StoredLinkPoint door = doors.front();
  for (graph::Anchor& anchor : door.point.anchors) anchor.T_map_place.x -= 0.7;
  ASSERT_OK(link_points_.Update(Soon(), door));
  expect_fresh("other hits are seen through the door");
}

TEST_F(KnownScansTest, NothingIsReadIfThePredictionIsNotSure) {
  server::SeenGrounds grounds(100 << 20);
  const auto graph = server::ReadSiteGraph(graph_, Soon(), site_, nullptr);
  ASSERT_OK(graph);
  ASSERT_OK_AND_ASSIGN(
      const auto known,
      server::ReadKnownScans(
          {.stores = stores_, .site = site_, .graph = (*graph)->graph(), .options = options_, .grounds = grounds}, map_,
          {{}, Eigen::Vector3d(100.0, 100.0, 0.001).asDiagonal()}));
  EXPECT_EQ(known.ground, nullptr);
  EXPECT_FALSE(known.recording);
  EXPECT_EQ(grounds.bytes(), 0U);
}

}  // namespace
}  // namespace enfilade::testing

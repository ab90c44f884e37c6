// SPDX-License-Identifier: Apache-2.0
// Plans in use, and what others do to their maps, their level and themselves meanwhile.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "tests/rpc/prior/prior_map_fixture.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

bool IsAnywhere(const Eigen::Vector2d&) { return true; }
bool IsEast(const Eigen::Vector2d& sheet) { return sheet.x() > 330; }

// The walls of the building with both ends from `from` to `to`.
prior::PlanGraph Wing(double from, double to) {
  const prior::PlanGraph building = prior::DrawnBuilding();
  prior::PlanGraph wing;
  for (const prior::PlanWall& wall : building.walls) {
    const Eigen::Vector2d a = building.corners[static_cast<std::size_t>(wall.from)].point;
    const Eigen::Vector2d b = building.corners[static_cast<std::size_t>(wall.to)].point;
    if (std::min(a.x(), b.x()) < from || std::max(a.x(), b.x()) > to) continue;
    const int first = static_cast<int>(wing.corners.size());
    wing.corners.push_back({a});
    wing.corners.push_back({b});
    wing.walls.push_back({.from = first, .to = first + 1});
  }
  return wing;
}

class PlansInUseTest : public PriorMapFixture {
 protected:
  static std::string NameOfPlan(const std::string& id) { return "sites/s/priorMaps/" + id; }
  void Import(const std::string& id, const prior::PlanGraph& plan, int level = 0) const {
    v1::ImportPriorMapManifest manifest = Manifest(id, id);
    manifest.set_level(level);
    ASSERT_OK(ImportPlan(prior::WriteGeoJsonPlan(plan), manifest).status());
  }
  // Map "m" has the west of the building; map "n", which only the plan joins to it, has the east.
  void ImportAndMapWings() {
    Import("plan", prior::DrawnBuilding());
    MapBuilding(IsWest);
    MakeMap("n");
    MapBuilding(IsEast, "n");
  }
  // By pairs, with each of which the plan lies as it should.
  v1::PriorMap AlignByPairs(const std::string& id, const std::vector<Eigen::Vector2d>& points, bool activate) const {
    v1::AlignPriorMapRequest request;
    request.set_name(NameOfPlan(id));
    request.set_activate(activate);
    for (const Eigen::Vector2d& sheet : points) *request.add_pairs() = Pair(sheet, Truth(sheet));
    const auto aligned = Align(request);
    EXPECT_OK(aligned.status());
    return aligned.ok() ? aligned->prior_map() : v1::PriorMap();
  }
  v1::GlobalPose WhereIs(const std::string& map) const {
    v1::GetGlobalPoseRequest request;
    request.mutable_map_pose()->set_map("sites/s/maps/" + map);
    request.mutable_map_pose()->mutable_pose_map_robot()->mutable_pose();
    const auto response = Call(&v1::GraphService::Stub::GetGlobalPose, request);
    EXPECT_OK(response.status());
    return response.ok() ? response->global_pose() : v1::GlobalPose();
  }
  bool IsPlaced(const std::string& map) const { return WhereIs(map).has_pose_world_robot(); }
  absl::Status DeleteMap(const std::string& map) const {
    v1::DeleteMapRequest request;
    request.set_name("sites/s/maps/" + map);
    return Call(&v1::MapService::Stub::DeleteMap, request).status();
  }
  std::vector<std::string> AssociatedMaps() const {
    v1::ListPriorAssociationsRequest request;
    request.set_parent(kPlan);
    request.set_page_size(1000);
    const auto response = Call(&v1::PriorMapService::Stub::ListPriorAssociations, request);
    EXPECT_OK(response.status());
    std::vector<std::string> maps;
    if (!response.ok()) return maps;
    for (const v1::PriorAssociation& one : response->associations()) maps.push_back(one.map());
    std::sort(maps.begin(), maps.end());
    maps.erase(std::unique(maps.begin(), maps.end()), maps.end());
    return maps;
  }

  const std::vector<Eigen::Vector2d> corners_ = {{0, 0}, {500, 20}, {30, 400}};
};

TEST_F(PlansInUseTest, OneIsDeletedByForceOnly) {
  Import("plan", prior::DrawnBuilding());
  MapBuilding(IsWest);
  ASSERT_EQ(AlignByPairs("plan", corners_, true).state(), v1::PriorMap::STATE_ACTIVE);
  EXPECT_STATUS(Delete(), absl::StatusCode::kFailedPrecondition,
                ::testing::AllOf(HasSubstr(kPlan), HasSubstr("sites/s/maps/m")));
  EXPECT_EQ(Get().state(), v1::PriorMap::STATE_ACTIVE);
  EXPECT_CODE(Delete(Get().etag()), absl::StatusCode::kFailedPrecondition);
  ASSERT_OK(Delete(Get().etag(), true));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.prior_map_files"), "0");
  Import("plan", prior::DrawnBuilding());
  ASSERT_EQ(AlignByPairs("plan", corners_, false).state(), v1::PriorMap::STATE_PROPOSED);
  EXPECT_OK(Delete()) << "it is not in use";
}

TEST_F(PlansInUseTest, OfTheSameRoomsThereIsOneAtMost) {
  for (const char* id : {"plan", "other"}) Import(id, prior::DrawnBuilding());
  Import("upstairs", prior::DrawnBuilding(), 1);
  MapBuilding(IsWest);
  ASSERT_EQ(AlignByPairs("plan", corners_, true).state(), v1::PriorMap::STATE_ACTIVE);
  const v1::PriorMap other = AlignByPairs("other", corners_, true);
  EXPECT_EQ(other.state(), v1::PriorMap::STATE_PROPOSED) << "what was found is kept";
  EXPECT_THAT(other.reason(), HasSubstr(kPlan));
  EXPECT_STATUS(Activate("", other.name()), absl::StatusCode::kFailedPrecondition, HasSubstr(kPlan));
  EXPECT_EQ(Get(other.name()).state(), v1::PriorMap::STATE_PROPOSED);
  EXPECT_OK(Activate().status()) << "it is in use already";

  ASSERT_OK(Suspend().status());
  ASSERT_OK(Activate("", other.name()).status());
  EXPECT_STATUS(Activate(), absl::StatusCode::kFailedPrecondition, HasSubstr(other.name()));
  EXPECT_EQ(Get().state(), v1::PriorMap::STATE_SUSPENDED);
}

TEST_F(PlansInUseTest, OfManyThatAreActivatedAtOnceOneIsInUse) {
  std::vector<std::string> ids = {"a", "b", "c", "d"};
  MapBuilding(IsWest);
  for (const std::string& id : ids) {
    Import(id, prior::DrawnBuilding());
    ASSERT_EQ(AlignByPairs(id, corners_, false).state(), v1::PriorMap::STATE_PROPOSED);
  }
  for (int round = 0; round < 5; ++round) {
    std::vector<absl::Status> answers(ids.size());
    std::vector<std::thread> callers;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      callers.emplace_back([&, i] { answers[i] = Activate("", NameOfPlan(ids[i])).status(); });
    }
    for (std::thread& caller : callers) caller.join();
    EXPECT_EQ(std::count(answers.begin(), answers.end(), absl::OkStatus()), 1);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const bool is_active = Get(NameOfPlan(ids[i])).state() == v1::PriorMap::STATE_ACTIVE;
      EXPECT_EQ(is_active, answers[i].ok()) << answers[i];
      if (is_active) {
        ASSERT_OK(Suspend("", NameOfPlan(ids[i])).status());
      } else {
        EXPECT_THAT(answers[i].code(),
                    ::testing::AnyOf(absl::StatusCode::kFailedPrecondition, absl::StatusCode::kAborted));
      }
    }
  }
}

TEST_F(PlansInUseTest, PlansOfNeighbouringWingsAreInUseTogether) {
  Import("west", Wing(0, 320));
  Import("east", Wing(320, 880));
  MapBuilding(IsAnywhere);
  EXPECT_EQ(AlignByPairs("west", {{0, 0}, {320, 200}, {0, 480}}, true).state(), v1::PriorMap::STATE_ACTIVE);
  const v1::PriorMap east = AlignByPairs("east", {{520, 0}, {880, 0}, {680, 320}}, true);
  EXPECT_EQ(east.state(), v1::PriorMap::STATE_ACTIVE) << east.reason();
}

TEST_F(PlansInUseTest, AMapThatIsMadeAgainIsNotPlacedByWhatTheDeletedOneHasSeen) {
  ImportAndMapWings();
  v1::AlignPriorMapRequest request;
  request.set_activate(true);
  ASSERT_OK_AND_ASSIGN(const auto aligned, Align(request));
  ASSERT_THAT(aligned.prior_map().alignment().joined_maps(), ElementsAre("sites/s/maps/n"));
  ASSERT_TRUE(Eventually([&] { return IsPlaced("n"); }));
  ASSERT_OK(DeleteMap("n"));
  EXPECT_EQ(Get().state(), v1::PriorMap::STATE_ACTIVE);
  EXPECT_THAT(Get().alignment().maps(), ElementsAre("sites/s/maps/m"));
  EXPECT_THAT(Get().alignment().joined_maps(), ElementsAre());
  EXPECT_NE(Get().etag(), aligned.prior_map().etag());

  MakeMap("n");
  v1::OptimizeGraphRequest optimize;
  optimize.set_site("sites/s");
  ASSERT_OK(Call(&v1::GraphService::Stub::OptimizeGraph, optimize).status());
  EXPECT_FALSE(IsPlaced("n"));
  EXPECT_THAT(AssociatedMaps(), ElementsAre("sites/s/maps/m"));
  Restart(Options());
  EXPECT_FALSE(IsPlaced("n")) << "a server that has not seen the deletion";
  ASSERT_OK(Suspend().status());
  EXPECT_THAT(AssociatedMaps(), ElementsAre("sites/s/maps/m"));
}

TEST_F(PlansInUseTest, AMapThatIsDeletedDuringTheAlignmentIsLeftOut) {
  ImportAndMapWings();
  v1::AlignPriorMapRequest request;
  request.set_activate(true);
  absl::StatusOr<v1::AlignPriorMapResponse> aligned = absl::UnknownError("");
  std::thread caller([&] { aligned = Align(request); });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_OK(DeleteMap("n"));
  MakeMap("n");
  caller.join();
  ASSERT_OK(aligned.status());
  EXPECT_EQ(aligned->prior_map().state(), v1::PriorMap::STATE_ACTIVE) << aligned->prior_map().reason();
  EXPECT_THAT(Get().alignment().maps(), ElementsAre("sites/s/maps/m"));
  EXPECT_THAT(AssociatedMaps(), ElementsAre("sites/s/maps/m"));
  EXPECT_FALSE(IsPlaced("n"));
  EXPECT_OK(Export({}).status());
}

TEST_F(PlansInUseTest, MapsComeAndGoWhileAPlanIsAligned) {
  Import("plan", prior::DrawnBuilding());
  MapBuilding(IsWest);
  v1::AlignPriorMapRequest request;
  request.set_validate_only(true);
  for (const Eigen::Vector2d& sheet : corners_) *request.add_pairs() = Pair(sheet, Truth(sheet));
  std::atomic<bool> done = false;
  std::thread others([&] {
    while (!done) {
      MakeMap("n");
      MapBuilding(IsEast, "n");
      EXPECT_OK(DeleteMap("n"));
    }
  });
  for (int i = 0; i < 5; ++i) EXPECT_OK(Align(request).status());
  done = true;
  others.join();
}

}  // namespace
}  // namespace enfilade::testing

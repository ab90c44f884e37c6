// SPDX-License-Identifier: Apache-2.0
// AlignMaps: one imported map fitted to another.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "client/sdk/api/map_import.h"
#include "core/grid/files/map_files.h"
#include "core/grid/map_raster.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "tests/rpc/graph_fixture.h"
#include "tests/support/buildings/mapped_building.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

using Stub = v1::GraphService::Stub;

// Not one of those that the alignment was tried on.
constexpr std::uint64_t kBuilding = 7001;

class AlignMapsTest : public GraphTest {
 protected:
  void Import(const std::string& map, const grid::OccupancyGrid& grid) const {
    ASSERT_OK_AND_ASSIGN(const auto files, grid::RenderFiles(grid::FromOccupancyGrid(grid), map, {}));
    std::vector<client::NamedFile> named;
    for (const grid::MapFile& file : files) named.push_back({file.name, file.bytes});
    ASSERT_OK(client::ImportMap(*connection_, "sites/s/maps/" + map, v1::MAP_DIALECT_NAV2, named));
  }
  static v1::AlignMapsRequest Request(const std::string& a, const std::string& b) {
    v1::AlignMapsRequest request;
    request.set_map_a("sites/s/maps/" + a);
    request.set_map_b("sites/s/maps/" + b);
    return request;
  }
  static v1::AlignMapsRequest Request(const std::string& a, const std::string& b, const Pose2& guess) {
    v1::AlignMapsRequest request = Request(a, b);
    *request.mutable_pose_a_b() = convert::ToProto(guess);
    return request;
  }
};

TEST_F(AlignMapsTest, FindsThePlaceFromAPoorGuessAndStoresNothing) {
  const MapPair pair = TwoMapsOfABuilding(kBuilding);
  Import("b", pair.a);
  Import("c", pair.b);
  const std::int64_t version = AwaitSolution().graph_version();
  const Pose2 guess = pair.T_a_b * Pose2{2.0, -2.2, 20 * kDegree};
  ASSERT_OK_AND_ASSIGN(const v1::AlignMapsResponse found, Call(&Stub::AlignMaps, Request("b", "c", guess)));
  EXPECT_TRUE(found.accepted()) << found.reason();
  const Pose2 pose = convert::FromProto(found.pose_a_b().pose());
  EXPECT_THAT(pose, PoseNear(pair.T_a_b, 0.1, 0.5 * kDegree));
  ASSERT_OK_AND_ASSIGN(const PoseWithCovariance at, convert::FromProto("pose_a_b", found.pose_a_b()));
  EXPECT_GT(at.covariance(0, 0), 0.0);
  EXPECT_GT(found.score(), 0.75);
  EXPECT_GT(found.overlap_m2(), 10.0);
  EXPECT_NE(found.reason(), "");
  ASSERT_OK_AND_ASSIGN(const std::int64_t after, graph_store_.GetVersion(Soon(), site_));
  EXPECT_EQ(after, version);
  // The other way round it is the inverse.
  ASSERT_OK_AND_ASSIGN(const v1::AlignMapsResponse back, Call(&Stub::AlignMaps, Request("c", "b", Inverse(guess))));
  EXPECT_TRUE(back.accepted()) << back.reason();
  EXPECT_THAT(Inverse(convert::FromProto(back.pose_a_b().pose())), PoseNear(pose, 0.05, 0.3 * kDegree));
}

TEST_F(AlignMapsTest, WithoutAGuessTheGraphSaysWhereToLook) {
  const MapPair pair = TwoMapsOfABuilding(kBuilding);
  Import("b", pair.a);
  Import("far", pair.b);
  EXPECT_STATUS(Call(&Stub::AlignMaps, Request("b", "far")), absl::StatusCode::kFailedPrecondition,
                HasSubstr("set pose_a_b"));
  Join("bf", "b", "far", pair.T_a_b * Pose2{1.0, 1.0, 0.1});
  AwaitGraph([](const v1::Graph& graph) { return graph.link_points_size() == 3; });
  ASSERT_OK_AND_ASSIGN(const v1::AlignMapsResponse found, Call(&Stub::AlignMaps, Request("b", "far")));
  EXPECT_TRUE(found.accepted()) << found.reason();
  EXPECT_THAT(convert::FromProto(found.pose_a_b().pose()), PoseNear(pair.T_a_b, 0.1, 0.5 * kDegree));
}

TEST_F(AlignMapsTest, SaysThatMapsDoNotFit) {
  Import("b", TwoMapsOfABuilding(kBuilding).a);
  Import("c", TwoMapsOfABuilding(kBuilding + 1).b);
  v1::AlignMapsRequest request = Request("b", "c", {});
  ASSERT_OK_AND_ASSIGN(v1::AlignMapsResponse found, Call(&Stub::AlignMaps, request));
  EXPECT_FALSE(found.accepted()) << found.reason();
  EXPECT_NE(found.reason(), "");
  // So far away that they cannot meet.
  request = Request("b", "c", {1e6, 0, 0});
  ASSERT_OK_AND_ASSIGN(found, Call(&Stub::AlignMaps, request));
  EXPECT_FALSE(found.accepted());
  EXPECT_FALSE(found.has_pose_a_b());
}

TEST_F(AlignMapsTest, RefusesWhatIsWrong) {
  Import("b", TwoMapsOfABuilding(kBuilding).a);
  EXPECT_STATUS(Call(&Stub::AlignMaps, Request("b", "b", {})), absl::StatusCode::kInvalidArgument,
                HasSubstr("two maps"));
  EXPECT_STATUS(Call(&Stub::AlignMaps, Request("b", "c", {})), absl::StatusCode::kFailedPrecondition,
                HasSubstr("maps/c has no revision"));
  EXPECT_CODE(Call(&Stub::AlignMaps, Request("b", "none", {})), absl::StatusCode::kNotFound);
  Import("c", TwoMapsOfABuilding(kBuilding).b);
  v1::AlignMapsRequest request = Request("b", "c", {});
  request.set_radius_m(21);
  EXPECT_STATUS(Call(&Stub::AlignMaps, request), absl::StatusCode::kInvalidArgument, HasSubstr("radius_m is 21"));
  request.set_radius_m(-1);
  EXPECT_CODE(Call(&Stub::AlignMaps, request), absl::StatusCode::kInvalidArgument);
  request.set_radius_m(5);
  request.set_yaw_range_rad(4);
  EXPECT_STATUS(Call(&Stub::AlignMaps, request), absl::StatusCode::kInvalidArgument, HasSubstr("yaw_range_rad is 4"));
  request.set_yaw_range_rad(0);
  request.mutable_pose_a_b()->set_x(std::numeric_limits<double>::infinity());
  EXPECT_STATUS(Call(&Stub::AlignMaps, request), absl::StatusCode::kInvalidArgument, HasSubstr("pose_a_b"));
  request = Request("b", "c", {});
  request.set_map_b("sites/other/maps/c");
  EXPECT_STATUS(Call(&Stub::AlignMaps, request), absl::StatusCode::kInvalidArgument, HasSubstr("sites"));
  v1::UpdateMapRequest upstairs;
  upstairs.mutable_map()->set_name("sites/s/maps/c");
  upstairs.mutable_map()->set_level(1);
  upstairs.mutable_update_mask()->add_paths("level");
  ASSERT_OK(Call(&v1::MapService::Stub::UpdateMap, upstairs));
  EXPECT_STATUS(Call(&Stub::AlignMaps, Request("b", "c", {})), absl::StatusCode::kInvalidArgument,
                HasSubstr("level 1"));
}

}  // namespace
}  // namespace enfilade::testing

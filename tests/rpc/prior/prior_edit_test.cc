// SPDX-License-Identifier: Apache-2.0
// People correct a plan.
#include <algorithm>
#include <string>

#include "core/prior/formats/geojson_plan.h"
#include "core/prior/plan/planar.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "tests/rpc/prior/prior_map_fixture.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

class PriorEditTest : public PriorMapFixture {
 protected:
  absl::StatusOr<v1::EditPriorMapResponse> Edit(const prior::PlanGraph& plan, bool validate_only = false) const {
    v1::EditPriorMapRequest request;
    request.set_plan(prior::WriteGeoJsonPlan(plan));
    request.set_validate_only(validate_only);
    return Edit(request);
  }
  absl::StatusOr<v1::EditPriorMapResponse> Edit(v1::EditPriorMapRequest request) const {
    request.set_name(kPlan);
    return Call(&v1::PriorMapService::Stub::EditPriorMap, request);
  }
  prior::PlanGraph Stored() const {
    const auto files = Export({v1::PRIOR_MAP_PRODUCT_PLAN});
    EXPECT_OK(files.status());
    const auto plan = prior::ReadGeoJsonPlan(files->at("plan.geojson"));
    EXPECT_OK(plan.status());
    return *plan;
  }
  // Without the wall of the building that begins at this point of the sheet, 20 units a metre.
  static prior::PlanGraph Without(prior::PlanGraph plan, const Eigen::Vector2d& from) {
    std::erase_if(plan.walls, [&](const prior::PlanWall& wall) {
      return plan.corners[static_cast<std::size_t>(wall.from)].point == from;
    });
    return plan;
  }
};

TEST_F(PriorEditTest, APlanIsCorrectedAsAWhole) {
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap imported, ImportDrawnBuilding());
  prior::PlanGraph drawn = Without(Stored(), {400, 80});  // two walls that stand in a room
  prior::DrawWall(drawn, {400, 0}, {399.7, 200.4});
  drawn.doors.push_back({.from = {400, 100}, .to = {400, 120}});
  drawn.metres_per_unit = 0.05;
  ASSERT_OK_AND_ASSIGN(const auto would_be, Edit(drawn, true));
  EXPECT_EQ(Get().SerializeAsString(), imported.SerializeAsString()) << "only validated";
  ASSERT_OK_AND_ASSIGN(const auto edited, Edit(drawn));
  EXPECT_EQ(edited.changes().SerializeAsString(), would_be.changes().SerializeAsString());
  EXPECT_EQ(edited.changes().walls_added(), 1);
  EXPECT_EQ(edited.changes().walls_removed(), 1);
  EXPECT_EQ(edited.changes().doors_added(), 1);
  EXPECT_TRUE(edited.changes().scale_changed());
  EXPECT_EQ(edited.prior_map().state(), v1::PriorMap::STATE_NEW);
  EXPECT_THAT(edited.prior_map().reason(), HasSubstr("corrected"));
  EXPECT_NE(edited.prior_map().etag(), imported.etag());
  EXPECT_EQ(Get().SerializeAsString(), edited.prior_map().SerializeAsString());
  const prior::PlanGraph stored = Stored();
  EXPECT_TRUE(prior::IsPlanar(stored));
  EXPECT_EQ(edited.prior_map().elements().walls(), static_cast<int>(stored.walls.size()));
  EXPECT_EQ(edited.prior_map().elements().rooms(), static_cast<int>(stored.rooms.size()));
  EXPECT_EQ(edited.prior_map().elements().metres_per_unit(), 0.05);
  EXPECT_EQ(would_be.prior_map().elements().SerializeAsString(), edited.prior_map().elements().SerializeAsString());
  ASSERT_EQ(stored.doors.size(), 1U);
  const auto is_at = [&](const Eigen::Vector2d& p) {
    return std::any_of(stored.corners.begin(), stored.corners.end(),
                       [&](const auto& one) { return (one.point - p).norm() < 0.5; });
  };
  EXPECT_TRUE(is_at({400, 100}) && is_at({400, 120})) << "the jambs";
  EXPECT_FALSE(is_at({400, 80}));

  ASSERT_OK_AND_ASSIGN(const auto again, Edit(stored));
  EXPECT_EQ(again.prior_map().etag(), edited.prior_map().etag()) << "nothing differs";
}

TEST_F(PriorEditTest, AMeasureGivesTheScale) {
  ASSERT_OK(ImportDrawnBuilding().status());
  const std::string before = Export({v1::PRIOR_MAP_PRODUCT_PLAN})->at("plan.geojson");
  v1::EditPriorMapRequest request;
  request.mutable_measure()->set_to_x(300);
  request.mutable_measure()->set_to_y(400);
  request.mutable_measure()->set_length_m(25);
  ASSERT_OK_AND_ASSIGN(const auto edited, Edit(request));
  EXPECT_EQ(edited.prior_map().elements().metres_per_unit(), 0.05);
  EXPECT_TRUE(edited.changes().scale_changed());
  EXPECT_EQ(edited.changes().walls_added() + edited.changes().walls_removed(), 0);
  EXPECT_EQ(Stored().metres_per_unit, 0.05);
  EXPECT_EQ(Stored().walls.size(), prior::DrawnBuilding().walls.size());
  EXPECT_NE(Export({v1::PRIOR_MAP_PRODUCT_PLAN})->at("plan.geojson"), before);
}

TEST_F(PriorEditTest, RefusalsNameWhatIsWrongAndChangeNothing) {
  ASSERT_OK(ImportDrawnBuilding().status());
  const std::string before = Get().SerializeAsString();
  v1::EditPriorMapRequest request;
  EXPECT_STATUS(Edit(request), absl::StatusCode::kInvalidArgument, HasSubstr("expected plan, measure"));
  request.mutable_measure()->set_length_m(3);
  EXPECT_STATUS(Edit(request), absl::StatusCode::kInvalidArgument, HasSubstr("measure: "));
  request.clear_measure();
  request.set_plan("{\"type\":\"FeatureCollection\"}");
  EXPECT_STATUS(Edit(request), absl::StatusCode::kInvalidArgument, HasSubstr("plan: "));
  prior::PlanGraph few = Stored();
  few.walls.resize(7);
  EXPECT_STATUS(Edit(few), absl::StatusCode::kInvalidArgument, HasSubstr("7 walls, 8 needed"));
  prior::PlanGraph thick = Stored();
  thick.walls[4].thickness = -2;
  EXPECT_STATUS(Edit(thick), absl::StatusCode::kInvalidArgument, HasSubstr("wall 4 has a thickness of -2"));
  request.set_plan(prior::WriteGeoJsonPlan(Without(Stored(), {400, 80})));
  request.set_etag("1");
  EXPECT_CODE(Edit(request), absl::StatusCode::kAborted);
  EXPECT_EQ(Get().SerializeAsString(), before);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.blobs"), "2");
  request.set_name("sites/s/priorMaps/none");
  EXPECT_CODE(Call(&v1::PriorMapService::Stub::EditPriorMap, request), absl::StatusCode::kNotFound);
}

// What was made of the walls that are gone goes with them.
TEST_F(PriorEditTest, ACorrectedPlanIsOutOfUseUntilItIsAlignedAgain) {
  ASSERT_OK(ImportDrawnBuilding().status());
  v1::AlignPriorMapRequest align;
  align.set_from_last(true);
  EXPECT_CODE(Align(align), absl::StatusCode::kFailedPrecondition) << "it was never aligned";
  MapBuilding(IsWest);
  align.set_from_last(false);
  align.set_activate(true);
  ASSERT_OK_AND_ASSIGN(const auto first, Align(align));
  ASSERT_EQ(first.prior_map().state(), v1::PriorMap::STATE_ACTIVE) << first.prior_map().reason();
  const auto ties = [&] {
    return database_.SqlValue("SELECT count(*) FROM enfilade.prior_map_files WHERE product = 6");
  };
  ASSERT_EQ(ties(), "1");
  v1::GetGraphRequest graph;
  graph.set_site("sites/s");
  const auto version = [&] { return Call(&v1::GraphService::Stub::GetGraph, graph)->graph().graph_version(); };
  const std::int64_t before = version();

  ASSERT_OK_AND_ASSIGN(const auto edited, Edit(Without(Stored(), {400, 80})));
  EXPECT_EQ(edited.prior_map().state(), v1::PriorMap::STATE_NEW);
  EXPECT_THAT(edited.prior_map().reason(), HasSubstr("align it again"));
  EXPECT_TRUE(edited.prior_map().has_alignment()) << "where to begin";
  EXPECT_EQ(ties(), "0");
  EXPECT_GT(version(), before);
  EXPECT_CODE(Activate(), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(Suspend(), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(Export({v1::PRIOR_MAP_PRODUCT_CORRECTED}), absl::StatusCode::kFailedPrecondition);
  ASSERT_OK_AND_ASSIGN(const Files files, Export({}));
  std::vector<std::string> names;
  for (const auto& [name, bytes] : files) names.push_back(name);
  EXPECT_THAT(names, UnorderedElementsAre("sheet.geojson", "plan.geojson"));
  v1::ListPriorAssociationsRequest associations;
  associations.set_parent(kPlan);
  EXPECT_STATUS(Call(&v1::PriorMapService::Stub::ListPriorAssociations, associations),
                absl::StatusCode::kFailedPrecondition, HasSubstr("was corrected since it was aligned"));

  align.set_from_last(true);
  ASSERT_OK_AND_ASSIGN(const auto second, Align(align));
  EXPECT_EQ(second.prior_map().state(), v1::PriorMap::STATE_ACTIVE) << second.prior_map().reason();
  EXPECT_EQ(second.prior_map().alignment().rival_ratio(), 0) << "no other place was looked at";
  EXPECT_LT((Placed(second.prior_map().alignment(), {100, 200}) - Truth({100, 200})).norm(), 0.1);
  EXPECT_EQ(ties(), "1");
  align.add_pairs();
  EXPECT_CODE(Align(align), absl::StatusCode::kInvalidArgument) << "pairs, and from_last";
}

// A wall that the plan has where robots have seen none.
TEST_F(PriorEditTest, ACorrectionRemovesWhatRobotsContradict) {
  prior::PlanGraph wrong = prior::DrawnBuilding();
  prior::DrawWall(wrong, {150, 0}, {150, 200});
  ASSERT_OK(ImportPlan(prior::WriteGeoJsonPlan(wrong), Manifest()).status());
  // Not up to a wall, of which robots would know the ground and not the wall.
  MapBuilding([](const Eigen::Vector2d& sheet) { return sheet.x() < 500; });
  ASSERT_OK_AND_ASSIGN(const auto first, Align());
  ASSERT_EQ(first.prior_map().state(), v1::PriorMap::STATE_PROPOSED) << first.prior_map().reason();
  const auto is_contradicted = [&] {
    const std::string walls = Export({v1::PRIOR_MAP_PRODUCT_CORRECTED})->at("walls.geojson");
    return walls.find("\"state\": \"contradicted\"") != std::string::npos;
  };
  EXPECT_TRUE(is_contradicted());
  ASSERT_OK(Edit(Without(Stored(), {150, 0})).status());
  v1::AlignPriorMapRequest align;
  align.set_from_last(true);
  ASSERT_OK_AND_ASSIGN(const auto second, Align(align));
  ASSERT_EQ(second.prior_map().state(), v1::PriorMap::STATE_PROPOSED) << second.prior_map().reason();
  EXPECT_LT(second.prior_map().alignment().contradicted(), first.prior_map().alignment().contradicted());
  EXPECT_FALSE(is_contradicted()) << Export({v1::PRIOR_MAP_PRODUCT_CORRECTED})->at("report.json");
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>
#include <vector>

#include "core/base/sha256.h"
#include "core/grid/files/map_files.h"
#include "core/prior/formats/geojson_plan.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "tests/rpc/prior/prior_map_fixture.h"
#include "tests/support/eventually.h"
#include "tests/support/plans/drawn_building.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;
class PriorMapTest : public PriorMapFixture {};

TEST_F(PriorMapTest, APlanIsImportedFoundAndCompleted) {
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap imported, ImportDrawnBuilding());
  EXPECT_EQ(imported.name(), kPlan);
  EXPECT_EQ(imported.state(), v1::PriorMap::STATE_NEW);
  EXPECT_EQ(imported.elements().walls(), static_cast<int>(prior::DrawnBuilding().walls.size()));
  MapBuilding(IsWest);
  ASSERT_OK_AND_ASSIGN(const auto aligned, Align());
  ASSERT_EQ(aligned.prior_map().state(), v1::PriorMap::STATE_PROPOSED) << aligned.prior_map().reason();
  const v1::PriorAlignment& alignment = aligned.prior_map().alignment();
  EXPECT_FALSE(alignment.mirrored());
  EXPECT_GT(alignment.explained(), 0.8);
  EXPECT_EQ(alignment.maps(0), "sites/s/maps/m");
  EXPECT_LT((Placed(alignment, {100, 200}) - Truth({100, 200})).norm(), 0.1);
  EXPECT_LT((Placed(alignment, {880, 0}) - Truth({880, 0})).norm(), 0.3) << "what no robot has seen";

  ASSERT_OK_AND_ASSIGN(const Files files, Export({}));
  std::vector<std::string> names;
  for (const auto& [name, bytes] : files) names.push_back(name);
  EXPECT_THAT(names,
              UnorderedElementsAre("sheet.geojson", "plan.geojson", "walls.geojson", "walls.svg", "walls.building.yaml",
                                   "report.json", "planning.png", "planning.yaml", "planning-mask.png", "fit.png"));
  EXPECT_EQ(files.at("sheet.geojson"), prior::WriteGeoJsonPlan(prior::DrawnBuilding()));
  EXPECT_THAT(files.at("walls.geojson"), HasSubstr("\"unseen\""));
  ASSERT_OK_AND_ASSIGN(const Files planning, Export({v1::PRIOR_MAP_PRODUCT_PLANNING}));
  EXPECT_EQ(planning.size(), 3U);
  std::vector<grid::MapFile> nav2;
  for (const char* name : {"planning.png", "planning.yaml"}) nav2.push_back({name, planning.at(name)});
  const auto map = grid::ImportFiles(nav2, grid::MapDialect::kNav2);
  EXPECT_OK(map.status()) << "it is an ordinary map";

  EXPECT_EQ(Activate()->state(), v1::PriorMap::STATE_ACTIVE);
  EXPECT_EQ(Suspend()->state(), v1::PriorMap::STATE_SUSPENDED);
  EXPECT_EQ(Activate()->state(), v1::PriorMap::STATE_ACTIVE);
}

TEST_F(PriorMapTest, PeopleShowThePlace) {
  ASSERT_OK(ImportDrawnBuilding().status());
  MapBuilding(IsWest);
  v1::AlignPriorMapRequest request;
  for (const Eigen::Vector2d& sheet : {Eigen::Vector2d(0, 0), {500, 20}, {30, 400}}) {
    v1::ControlPair& pair = *request.add_pairs();
    pair.set_sheet_x(sheet.x());
    pair.set_sheet_y(sheet.y());
    pair.set_map("sites/s/maps/m");
    pair.set_x_m(Truth(sheet).x() + 0.2);
    pair.set_y_m(Truth(sheet).y());
  }
  request.set_activate(true);
  ASSERT_OK_AND_ASSIGN(const auto aligned, Align(request));
  EXPECT_EQ(aligned.prior_map().state(), v1::PriorMap::STATE_ACTIVE) << aligned.prior_map().reason();
  ASSERT_EQ(aligned.pair_residuals_m_size(), 3);
  for (const double residual : aligned.pair_residuals_m()) EXPECT_NEAR(residual, 0.2, 0.1) << "the clicks were wrong";
  EXPECT_EQ(Get().alignment().pairs_size(), 3);
  EXPECT_EQ(Get().alignment().pairs(1).sheet_x(), 500);

  request.mutable_pairs(1)->set_map("sites/s/maps/nowhere");
  EXPECT_CODE(Align(request), absl::StatusCode::kInvalidArgument);
  request.mutable_pairs()->DeleteSubrange(1, 2);
  EXPECT_CODE(Align(request), absl::StatusCode::kInvalidArgument) << "one pair";
  EXPECT_EQ(Get().state(), v1::PriorMap::STATE_ACTIVE) << "an error changes nothing";
}

TEST_F(PriorMapTest, APlanThatFitsInManyPlacesIsRefusedAndSaysWhy) {
  ASSERT_OK(ImportDrawnBuilding().status());
  MapBuilding(IsOneRoom);
  ASSERT_OK_AND_ASSIGN(const auto aligned, Align());
  EXPECT_EQ(aligned.prior_map().state(), v1::PriorMap::STATE_DIVERGED);
  EXPECT_FALSE(aligned.prior_map().reason().empty());
  EXPECT_FALSE(aligned.prior_map().has_alignment());
  EXPECT_CODE(Activate(), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(Suspend(), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(Export({v1::PRIOR_MAP_PRODUCT_CORRECTED}), absl::StatusCode::kFailedPrecondition);
}

// There is nothing to tie it to.
TEST_F(PriorMapTest, APlanOfOneMapMovesNothing) {
  MapBuilding(IsWest);
  v1::GetGraphRequest request;
  request.set_site("sites/s");
  const auto placed = [&] {
    const auto response = Call(&v1::GraphService::Stub::GetGraph, request);
    EXPECT_OK(response.status());
    std::string maps;
    if (response.ok()) {
      for (const v1::GraphMap& map : response->graph().maps()) maps += map.SerializeAsString();
    }
    return maps;
  };
  const std::string before = placed();
  ASSERT_OK(ImportDrawnBuilding().status());
  v1::AlignPriorMapRequest align;
  align.set_activate(true);
  ASSERT_OK(Align(align).status());
  EXPECT_EQ(placed(), before);
  ASSERT_OK(Suspend().status());
  EXPECT_EQ(placed(), before);
}

TEST_F(PriorMapTest, ValidateOnlyStoresNothing) {
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap imported, ImportDrawnBuilding());
  v1::AlignPriorMapRequest request;
  EXPECT_CODE(Align(request), absl::StatusCode::kFailedPrecondition) << "nothing is mapped";
  MapBuilding(IsWest);
  request.set_validate_only(true);
  ASSERT_OK_AND_ASSIGN(const auto would_be, Align(request));
  EXPECT_EQ(would_be.prior_map().state(), v1::PriorMap::STATE_PROPOSED);
  EXPECT_TRUE(would_be.prior_map().has_alignment());
  EXPECT_EQ(Get().SerializeAsString(), imported.SerializeAsString());
  request.set_etag("1");
  EXPECT_CODE(Align(request), absl::StatusCode::kAborted);
}

TEST_F(PriorMapTest, RefusesWhatIsNoPlan) {
  const std::string plan = prior::WriteGeoJsonPlan(prior::DrawnBuilding());
  for (const std::string& bytes : {std::string("nonsense"), plan.substr(0, plan.size() / 2), std::string(1000, '\0')}) {
    const auto refused = ImportPlan(bytes, Manifest());
    EXPECT_CODE(refused, absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(refused.status().message(), HasSubstr("drawing.geojson"));
  }
  EXPECT_CODE(ImportPlan(plan, Manifest(), Sha256("something else")), absl::StatusCode::kDataLoss);
  v1::ImportPriorMapManifest manifest = Manifest();
  manifest.set_parent("sites/nowhere");
  EXPECT_CODE(ImportPlan(plan, manifest), absl::StatusCode::kNotFound);
  manifest = Manifest();
  manifest.mutable_file()->set_name("../plan.geojson");
  EXPECT_CODE(ImportPlan(plan, manifest), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(ImportPlan(plan, Manifest("plan", "")), absl::StatusCode::kInvalidArgument);
  manifest = Manifest();
  manifest.mutable_measure()->set_length_m(3);
  EXPECT_CODE(ImportPlan(plan, manifest), absl::StatusCode::kInvalidArgument) << "between one point and itself";
  v1::ListPriorMapsRequest list;
  list.set_parent("sites/s");
  EXPECT_EQ(Call(&v1::PriorMapService::Stub::ListPriorMaps, list)->prior_maps_size(), 0);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.blobs"), "0");
}

TEST_F(PriorMapTest, IsListedRenamedAndDeleted) {
  const std::string plan = prior::WriteGeoJsonPlan(prior::DrawnBuilding());
  for (const char* id : {"b", "plan", "a"}) ASSERT_OK(ImportPlan(plan, Manifest(id, id)).status());
  EXPECT_CODE(ImportPlan(plan, Manifest("a", "new")), absl::StatusCode::kAlreadyExists);
  EXPECT_CODE(ImportPlan(plan, Manifest("new", "a")), absl::StatusCode::kAlreadyExists);
  v1::ListPriorMapsRequest list;
  list.set_parent("sites/s");
  list.set_page_size(2);
  ASSERT_OK_AND_ASSIGN(const auto first, Call(&v1::PriorMapService::Stub::ListPriorMaps, list));
  ASSERT_EQ(first.prior_maps_size(), 2);
  list.set_page_token(first.next_page_token());
  ASSERT_OK_AND_ASSIGN(const auto second, Call(&v1::PriorMapService::Stub::ListPriorMaps, list));
  ASSERT_EQ(second.prior_maps_size(), 1);
  EXPECT_EQ(second.prior_maps(0).name(), kPlan);

  v1::UpdatePriorMapRequest update;
  *update.mutable_prior_map() = Get();
  update.mutable_prior_map()->set_display_name("Cellar");
  ASSERT_OK_AND_ASSIGN(const auto renamed, Call(&v1::PriorMapService::Stub::UpdatePriorMap, update));
  EXPECT_EQ(renamed.prior_map().display_name(), "Cellar");
  EXPECT_CODE(Call(&v1::PriorMapService::Stub::UpdatePriorMap, update), absl::StatusCode::kAborted)
      << "its etag is old";
  v1::DeletePriorMapRequest remove;
  remove.set_name(kPlan);
  ASSERT_OK(Call(&v1::PriorMapService::Stub::DeletePriorMap, remove).status());
  EXPECT_CODE(Call(&v1::PriorMapService::Stub::DeletePriorMap, remove), absl::StatusCode::kNotFound);
}

TEST_F(PriorMapTest, GoesWithItsSite) {
  ASSERT_OK(ImportDrawnBuilding().status());
  v1::DeleteSiteRequest request;
  request.set_name("sites/s");
  request.set_force(true);
  ASSERT_OK(Call(&v1::SiteService::Stub::DeleteSite, request).status());
  EXPECT_TRUE(Eventually([&] { return database_.SqlValue("SELECT count(*) FROM enfilade.sites") == "0"; }));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.prior_maps"), "0");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.prior_map_files"), "0");
}

}  // namespace
}  // namespace enfilade::testing

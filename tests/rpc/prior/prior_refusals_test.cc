// SPDX-License-Identifier: Apache-2.0
// Calls for plans that are refused: the code, what the message names, and that nothing changes.
#include <thread>

#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "fmt/format.h"
#include "tests/rpc/prior/prior_map_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

class PriorRefusalsTest : public PriorMapFixture {
 protected:
  // The message of INVALID_ARGUMENT.
  std::string RefusedPairs(const std::vector<v1::ControlPair>& pairs) const {
    v1::AlignPriorMapRequest request;
    request.mutable_pairs()->Assign(pairs.begin(), pairs.end());
    const auto aligned = Align(request);
    EXPECT_CODE(aligned, absl::StatusCode::kInvalidArgument);
    return std::string(aligned.status().message());
  }
  std::string CountOfPlans() const { return database_.SqlValue("SELECT count(*) FROM enfilade.prior_maps"); }
};

TEST_F(PriorRefusalsTest, PairsThatDetermineNothingAreNamed) {
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap imported, ImportDrawnBuilding());
  MapBuilding(IsWest);
  const auto right = [](const Eigen::Vector2d& sheet) { return Pair(sheet, Truth(sheet), "sites/s/maps/m"); };
  EXPECT_THAT(RefusedPairs({right({0, 0})}), HasSubstr("1 pairs of points, at least 2"));
  EXPECT_THAT(RefusedPairs({right({0, 0}), right({500, 20}), right({0, 0})}), HasSubstr("pairs 1 and 3 show the same"));
  EXPECT_THAT(RefusedPairs({right({0, 0}), right({5, 0}), right({10, 0})}), HasSubstr("the pairs are at most 0.5 m"))
      << "20 units are a metre";
  v1::ControlPair not_finite = right({500, 20});
  not_finite.set_y_m(std::nan(""));
  EXPECT_THAT(RefusedPairs({right({0, 0}), not_finite}), HasSubstr("pairs[1] has a coordinate that is not finite"));
  EXPECT_THAT(RefusedPairs({right({0, 0}), Pair({500, 20}, {1e9, 0})}), HasSubstr("by the pairs the plan is"));
  EXPECT_EQ(Get().SerializeAsString(), imported.SerializeAsString());
}

TEST_F(PriorRefusalsTest, PairsInMapsThatTheLevelHasNotAreNamed) {
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap imported, ImportDrawnBuilding());
  MapBuilding(IsWest);
  MakeMap("upstairs", 1);
  MapBuilding(IsWest, "upstairs");
  MakeMap("unjoined");
  MapBuilding(IsWest, "unjoined");
  for (const char* map : {"sites/s/maps/upstairs", "sites/s/maps/unjoined", "sites/s/maps/nowhere"}) {
    EXPECT_THAT(RefusedPairs({Pair({0, 0}, Truth({0, 0}), "sites/s/maps/m"), Pair({500, 20}, Truth({500, 20}), map)}),
                HasSubstr(fmt::format("pairs[1].map is \"{}\"", std::string(map).substr(13))));
  }
  for (const char* map : {"sites/other/maps/m", "maps/m", "sites/s/maps/m/revisions/1"}) {
    EXPECT_THAT(RefusedPairs({Pair({0, 0}, {0, 0}, map), Pair({500, 20}, {9, 9})}), HasSubstr("pairs[0].map"));
  }
  EXPECT_EQ(Get().SerializeAsString(), imported.SerializeAsString());
}

TEST_F(PriorRefusalsTest, StaleEtagsChangeNothing) {
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap imported, ImportDrawnBuilding());
  MapBuilding(IsWest);
  v1::AlignPriorMapRequest align;
  align.set_etag(imported.etag());
  for (const Eigen::Vector2d& sheet : {Eigen::Vector2d(0, 0), {500, 20}}) {
    *align.add_pairs() = Pair(sheet, Truth(sheet));
  }
  ASSERT_OK(Align(align).status());
  const v1::PriorMap aligned = Get();
  v1::UpdatePriorMapRequest update;
  update.mutable_prior_map()->set_name(kPlan);
  update.mutable_prior_map()->set_display_name("Cellar");
  for (const bool is_stale : {true, false}) {
    const std::string etag = is_stale ? imported.etag() : "no etag";
    const absl::StatusCode code = is_stale ? absl::StatusCode::kAborted : absl::StatusCode::kInvalidArgument;
    align.set_etag(etag);
    update.mutable_prior_map()->set_etag(etag);
    EXPECT_CODE(Align(align), code);
    EXPECT_CODE(Activate(etag), code);
    EXPECT_CODE(Suspend(etag), code);
    EXPECT_CODE(Delete(etag, true), code);
    EXPECT_CODE(Call(&v1::PriorMapService::Stub::UpdatePriorMap, update), code);
  }
  EXPECT_EQ(Get().SerializeAsString(), aligned.SerializeAsString());
}

TEST_F(PriorRefusalsTest, AnImportIsSafeToRepeatWithTheSameRequestId) {
  const std::string plan = prior::WriteGeoJsonPlan(prior::DrawnBuilding());
  for (const char* id : {"", "named"}) {
    v1::ImportPriorMapManifest manifest = Manifest(id, fmt::format("Plan \"{}\"", id));
    manifest.set_request_id(fmt::format("request of {}", id));
    const std::string before = CountOfPlans();
    std::vector<absl::StatusOr<v1::PriorMap>> answers(4, absl::UnknownError(""));
    std::vector<std::thread> callers;
    for (auto& answer : answers) callers.emplace_back([&] { answer = ImportPlan(plan, manifest); });
    for (std::thread& caller : callers) caller.join();
    ASSERT_OK_AND_ASSIGN(const v1::PriorMap again, ImportPlan(plan, manifest));
    for (const auto& answer : answers) {
      ASSERT_OK(answer.status());
      EXPECT_EQ(answer->SerializeAsString(), again.SerializeAsString());
    }
    EXPECT_EQ(std::stoi(CountOfPlans()), std::stoi(before) + 1);
    const auto refused = [&](const std::string& bytes, const v1::ImportPriorMapManifest& other) {
      EXPECT_STATUS(ImportPlan(bytes, other), absl::StatusCode::kInvalidArgument, HasSubstr("request_id"));
    };
    refused(plan + " ", manifest);
    v1::ImportPriorMapManifest other = manifest;
    other.set_level(3);
    refused(plan, other);
    other = manifest;
    other.set_display_name("Another");
    refused(plan, other);
    other.set_request_id(std::string(129, 'x'));
    refused(plan, other);
  }
  v1::ImportPriorMapManifest taken = Manifest("", "Plan \"named\"");
  taken.set_request_id("a third request");
  EXPECT_CODE(ImportPlan(plan, taken), absl::StatusCode::kAlreadyExists) << "its display name is another plan's";
  EXPECT_EQ(CountOfPlans(), "2");
}

TEST_F(PriorRefusalsTest, FilesThatAreTooMuchStoreNothing) {
  std::string lines = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n";
  for (int i = 0; i < 20'000; ++i) lines += fmt::format("0\nLINE\n8\n0\n10\n{0}\n20\n0\n11\n{0}\n21\n1\n", i);
  lines += "0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
  for (int i = 0; i < 51; ++i) lines += "0\nINSERT\n8\n0\n2\nB\n";
  EXPECT_STATUS(ImportPlan(lines + "0\nENDSEC\n0\nEOF\n", Manifest()), absl::StatusCode::kResourceExhausted,
                HasSubstr("drawing.geojson: more than 1000000 lines"));
  const std::string nested = R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":)"
                             R"({"type":"LineString","coordinates":)" +
                             std::string(500'000, '[') + std::string(500'000, ']') + "}}]}";
  EXPECT_STATUS(ImportPlan(nested, Manifest()), absl::StatusCode::kInvalidArgument,
                HasSubstr("drawing.geojson: feature 0"));
  EXPECT_EQ(CountOfPlans(), "0");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.blobs"), "0");
}

TEST_F(PriorRefusalsTest, PlansOfOtherSitesAreNotFound) {
  ASSERT_OK(ImportDrawnBuilding().status());
  MapBuilding(IsWest);
  v1::AlignPriorMapRequest align;
  for (const Eigen::Vector2d& sheet : {Eigen::Vector2d(0, 0), {500, 20}}) {
    *align.add_pairs() = Pair(sheet, Truth(sheet));
  }
  align.set_activate(true);
  ASSERT_OK(Align(align).status());
  const v1::PriorMap before = Get();
  v1::CreateSiteRequest site;
  site.set_site_id("other");
  site.mutable_site()->set_display_name("Other");
  ASSERT_OK(Call(&v1::SiteService::Stub::CreateSite, site).status());

  const std::string name = "sites/other/priorMaps/plan";
  using Stub = v1::PriorMapService::Stub;
  const auto not_found = [&](auto method, auto request) {
    EXPECT_STATUS(Call(method, request), absl::StatusCode::kNotFound, HasSubstr(name)) << request.GetTypeName();
  };
  const auto named = [&](auto request) {
    request.set_name(name);
    return request;
  };
  const auto of_parent = [&](auto request) {
    request.set_parent(name);
    return request;
  };
  not_found(&Stub::GetPriorMap, named(v1::GetPriorMapRequest()));
  not_found(&Stub::DeletePriorMap, named(v1::DeletePriorMapRequest()));
  not_found(&Stub::AlignPriorMap, named(v1::AlignPriorMapRequest()));
  not_found(&Stub::ActivatePriorMap, named(v1::ActivatePriorMapRequest()));
  not_found(&Stub::SuspendPriorMap, named(v1::SuspendPriorMapRequest()));
  not_found(&Stub::ListPriorAssociations, of_parent(v1::ListPriorAssociationsRequest()));
  not_found(&Stub::ListPredictedLinkPoints, of_parent(v1::ListPredictedLinkPointsRequest()));
  v1::UpdatePriorMapRequest update;
  update.mutable_prior_map()->set_name(name);
  update.mutable_prior_map()->set_display_name("Mine");
  not_found(&Stub::UpdatePriorMap, update);
  EXPECT_CODE(Export({}, name), absl::StatusCode::kNotFound);
  v1::ListPriorMapsRequest list;
  list.set_parent("sites/other");
  EXPECT_EQ(Call(&Stub::ListPriorMaps, list)->prior_maps_size(), 0);
  EXPECT_EQ(Get().SerializeAsString(), before.SerializeAsString());

  v1::ImportPriorMapManifest own = Manifest();
  own.set_parent("sites/other");
  ASSERT_OK(ImportPlan(prior::WriteGeoJsonPlan(prior::DrawnBuilding()), own).status());
  align.set_name(name);
  align.mutable_pairs(1)->set_map("sites/s/maps/m");
  EXPECT_STATUS(Align(align), absl::StatusCode::kInvalidArgument, HasSubstr("pairs[1].map"));
  ASSERT_OK(Delete("", false, name));
  EXPECT_EQ(Get().SerializeAsString(), before.SerializeAsString());
}

}  // namespace
}  // namespace enfilade::testing

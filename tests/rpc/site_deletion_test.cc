// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "storage/postgres/driver/transaction.h"
#include "tests/rpc/server_test.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

class SiteDeletionRpcTest : public ServerTest {
 protected:
  absl::StatusOr<v1::DeleteSiteResponse> DeleteSite() {
    v1::DeleteSiteRequest request;
    request.set_name("sites/s");
    request.set_force(true);
    return Call(&v1::SiteService::Stub::DeleteSite, request);
  }
  absl::StatusOr<v1::GetSiteResponse> GetSite() {
    v1::GetSiteRequest request;
    request.set_name("sites/s");
    return Call(&v1::SiteService::Stub::GetSite, request);
  }
  absl::StatusOr<v1::CreateSiteResponse> CreateSite() {
    v1::CreateSiteRequest request;
    request.set_site_id("s");
    request.mutable_site()->set_display_name("Site");
    return Call(&v1::SiteService::Stub::CreateSite, request);
  }
  // Keeps the robot's row from being deleted, for as long as it lives.
  storage::postgres::Transaction HoldRobot() {
    auto held = storage::postgres::Transaction::Begin(*pool_, Soon());
    EXPECT_OK(held);
    EXPECT_OK(held->Execute({"test", "SELECT FROM enfilade.robots FOR UPDATE"}, storage::postgres::Params()));
    return *std::move(held);
  }
  template <typename Service, typename Request, typename Response>
  void ExpectRefused(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                     const Request& request) {
    EXPECT_STATUS(Call(method, request).status(), absl::StatusCode::kFailedPrecondition,
                  HasSubstr("sites/s is being deleted"));
  }
};

TEST_F(SiteDeletionRpcTest, ASiteThatIsBeingDeletedCanOnlyBeReadUntilItIsGone) {
  const std::string session = CreateSession(false);
  {
    const auto held = HoldRobot();
    ASSERT_OK_AND_ASSIGN(const v1::DeleteSiteResponse deleted, DeleteSite());
    EXPECT_TRUE(deleted.site().has_deletion());
    ASSERT_TRUE(Eventually([&] { return GetSite()->site().deletion().deleted_rows() > 0; }));
    EXPECT_OK(DeleteSite()) << "may be repeated";

    v1::GetMapRequest map;
    map.set_name("sites/s/maps/m");
    ExpectRefused(&v1::MapService::Stub::GetMap, map);
    v1::ListMapsRequest maps;
    maps.set_parent("sites/s");
    ExpectRefused(&v1::MapService::Stub::ListMaps, maps);
    v1::CreateMapRequest new_map;
    new_map.set_parent("sites/s");
    new_map.mutable_map()->set_display_name("New");
    ExpectRefused(&v1::MapService::Stub::CreateMap, new_map);
    v1::GetGraphRequest graph;
    graph.set_site("sites/s");
    ExpectRefused(&v1::GraphService::Stub::GetGraph, graph);
    v1::GetGlobalPoseRequest pose;  // which is answered without waiting
    pose.mutable_map_pose()->set_map("sites/s/maps/m");
    ExpectRefused(&v1::GraphService::Stub::GetGlobalPose, pose);
    v1::GetSessionRequest get_session;
    get_session.set_name(session);
    ExpectRefused(&v1::SessionService::Stub::GetSession, get_session);
    v1::UpdateSiteRequest update;
    update.mutable_site()->set_name("sites/s");
    update.mutable_site()->set_display_name("New");
    ExpectRefused(&v1::SiteService::Stub::UpdateSite, update);
    TestStream stream(*connection_, session);
    EXPECT_STATUS(stream.AwaitEnd(), absl::StatusCode::kFailedPrecondition, HasSubstr("is being deleted"));
    EXPECT_STATUS(CreateSite().status(), absl::StatusCode::kFailedPrecondition, HasSubstr("is being deleted"));
  }
  ASSERT_TRUE(Eventually([&] { return absl::IsNotFound(GetSite().status()); }));
  v1::ListAuditEntriesRequest audit;
  audit.set_parent("sites/s");
  ASSERT_OK_AND_ASSIGN(const v1::ListAuditEntriesResponse trail, Call(&v1::SiteService::Stub::ListAuditEntries, audit));
  EXPECT_TRUE(std::any_of(trail.entries().begin(), trail.entries().end(), [](const v1::AuditEntry& entry) {
    return entry.resource() == "sites/s" && entry.action() == v1::AuditEntry::ACTION_DELETED;
  }));
  audit.set_parent("sites/nowhere");
  EXPECT_CODE(Call(&v1::SiteService::Stub::ListAuditEntries, audit), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const v1::CreateSiteResponse again, CreateSite());
  EXPECT_FALSE(again.site().has_deletion());
  v1::ListMapsRequest maps;
  maps.set_parent("sites/s");
  EXPECT_TRUE(Eventually([&] {
    const auto listed = Call(&v1::MapService::Stub::ListMaps, maps);
    return listed.ok() && listed->maps().empty();
  }));
}

TEST_F(SiteDeletionRpcTest, AReplicaRefusesCallsForASiteThatAnotherOneDeletes) {
  const auto held = HoldRobot();
  database_.Sql("UPDATE enfilade.sites SET delete_time = now(), delete_actor = ''");  // as another replica does
  v1::ListMapsRequest maps;
  maps.set_parent("sites/s");
  EXPECT_TRUE(
      Eventually([&] { return absl::IsFailedPrecondition(Call(&v1::MapService::Stub::ListMaps, maps).status()); }));
}

}  // namespace
}  // namespace enfilade::testing

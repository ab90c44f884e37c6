// SPDX-License-Identifier: Apache-2.0
// PreviewGraph and ChangeGraph: changes of link points that are looked at first, and made together.
#include <algorithm>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "client/sdk/api/paging.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "tests/rpc/graph_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Stub = v1::GraphService::Stub;

class GraphEditTest : public GraphTest {
 protected:
  static std::string NameOf(const std::string& id) { return "sites/s/linkPoints/" + id; }
  static std::string MapOf(const std::string& id) { return "sites/s/maps/" + id; }

  absl::StatusOr<v1::LinkPoint> Read(const std::string& id) const {
    v1::GetLinkPointRequest request;
    request.set_name(NameOf(id));
    ENFILADE_ASSIGN_OR_RETURN(auto response, Call(&v1::LinkPointService::Stub::GetLinkPoint, request));
    return response.link_point();
  }
  // The change that moves an anchor, with the etag of what is stored.
  v1::GraphChange Move(const std::string& id, const std::string& map, const Pose2& by) const {
    v1::GraphChange change;
    const absl::StatusOr<v1::LinkPoint> stored = Read(id);
    EXPECT_OK(stored);
    *change.mutable_updated() = stored.value_or(v1::LinkPoint());
    for (v1::Anchor& anchor : *change.mutable_updated()->mutable_anchors()) {
      if (anchor.map() != MapOf(map)) continue;
      v1::Pose2& pose = *anchor.mutable_pose_map_place()->mutable_pose();
      pose.set_x(pose.x() + by.x);
      pose.set_y(pose.y() + by.y);
      pose.set_yaw(pose.yaw() + by.yaw);
    }
    return change;
  }
  static v1::GraphChange Creation(const std::string& name, const std::string& from, const std::string& to,
                                  const Pose2& T_from_place = {0, 3, 0}) {
    v1::GraphChange change;
    change.mutable_created()->set_name(name);
    for (const auto& [map, pose] : {std::pair(from, T_from_place), std::pair(to, Pose2{})}) {
      v1::Anchor& anchor = *change.mutable_created()->add_anchors();
      anchor.set_map(MapOf(map));
      *anchor.mutable_pose_map_place() = convert::ToProto(PoseWithCovariance{pose, graph::DefaultAnchorCovariance()});
    }
    return change;
  }
  absl::StatusOr<v1::PreviewGraphResponse> Preview(const std::vector<v1::GraphChange>& changes) const {
    v1::PreviewGraphRequest request;
    request.set_site("sites/s");
    request.mutable_changes()->Add(changes.begin(), changes.end());
    return Call(&Stub::PreviewGraph, request);
  }
  absl::StatusOr<v1::ChangeGraphResponse> Change(const std::vector<v1::GraphChange>& changes) const {
    return ChangeBy(*connection_, changes);
  }
  static absl::StatusOr<v1::ChangeGraphResponse> ChangeBy(const client::Connection& connection,
                                                          const std::vector<v1::GraphChange>& changes) {
    v1::ChangeGraphRequest request;
    request.set_site("sites/s");
    request.mutable_changes()->Add(changes.begin(), changes.end());
    return connection.Call(&Stub::ChangeGraph, request);
  }
  std::vector<v1::AuditEntry> Audit() const {
    v1::ListAuditEntriesRequest request;
    request.set_parent("sites/s");
    const auto entries = client::ListAll(*connection_, &v1::SiteService::Stub::ListAuditEntries, request,
                                         &v1::ListAuditEntriesResponse::entries);
    EXPECT_OK(entries);
    return entries.value_or(std::vector<v1::AuditEntry>());
  }
  static const v1::LinkPointResidual* ResidualOf(const v1::PreviewGraphResponse& preview, const std::string& id) {
    const auto found = std::find_if(preview.residuals().begin(), preview.residuals().end(),
                                    [&](const v1::LinkPointResidual& one) { return one.link_point() == NameOf(id); });
    return found == preview.residuals().end() ? nullptr : &*found;
  }
};

TEST_F(GraphEditTest, APreviewSaysWhatMovesAndStoresNothing) {
  const v1::Graph before = AwaitSolution();
  const std::size_t audited = Audit().size();
  ASSERT_OK_AND_ASSIGN(const v1::PreviewGraphResponse preview, Preview({Move("bc", "b", {0, 1, 0})}));
  EXPECT_EQ(preview.graph_version(), before.graph_version());
  ASSERT_EQ(preview.moved_maps_size(), 1);
  EXPECT_EQ(preview.moved_maps(0).map(), MapOf("c"));
  EXPECT_NEAR(preview.moved_maps(0).pose_world_map_before().pose().y(), 0.0, 1e-6);
  EXPECT_NEAR(preview.moved_maps(0).pose_world_map_after().pose().y(), 1.0, 1e-6);
  EXPECT_EQ(preview.moved_maps(0).pose_world_map_after().covariance_size(), 9);
  ASSERT_NE(ResidualOf(preview, "bc"), nullptr);
  EXPECT_NEAR(ResidualOf(preview, "bc")->gate(), 16.27, 0.01) << "99.9 % of chi-squared with 3 degrees of freedom";
  EXPECT_EQ(ResidualOf(preview, "mb"), nullptr) << "it is neither changed nor switched off";
  EXPECT_THAT(preview.disconnected_maps(), ElementsAre(MapOf("far")));
  const v1::Graph after = GetGraph();
  EXPECT_EQ(after.SerializeAsString(), before.SerializeAsString());
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_store_.GetVersion(Soon(), site_));
  EXPECT_EQ(version, before.graph_version());
  EXPECT_EQ(Audit().size(), audited);
}

TEST_F(GraphEditTest, WhatIsSavedIsWhatWasPreviewed) {
  AwaitSolution();
  Join("mc", "m", "c", {0, 5, 0}, {-10, 5, 0});
  AwaitSolution();
  const std::vector<v1::GraphChange> changes = {Move("mc", "c", {0.05, -0.1, 0.02}),
                                                Creation(NameOf("mf"), "m", "far")};
  ASSERT_OK_AND_ASSIGN(const v1::PreviewGraphResponse preview, Preview(changes));
  EXPECT_GT(preview.chi2_after(), preview.chi2_before());
  ASSERT_OK_AND_ASSIGN(const v1::ChangeGraphResponse changed, Change(changes));
  EXPECT_GT(changed.graph_version(), preview.graph_version());
  const v1::Graph solved = AwaitSolution();
  ASSERT_EQ(preview.moved_maps_size(), 3);
  EXPECT_EQ(preview.moved_maps(0).map(), MapOf("far")) << "it gets a place";
  EXPECT_FALSE(preview.moved_maps(0).has_pose_world_map_before());
  EXPECT_EQ(preview.disconnected_maps_size(), 0);
  for (const v1::MovedMap& moved : preview.moved_maps()) {
    const auto map = std::find_if(solved.maps().begin(), solved.maps().end(),
                                  [&](const v1::GraphMap& one) { return one.map() == moved.map(); });
    ASSERT_NE(map, solved.maps().end());
    const v1::Pose2& shown = moved.pose_world_map_after().pose();
    const v1::Pose2& saved = map->pose_world_map().pose();
    EXPECT_NEAR(shown.x(), saved.x(), 1e-5) << moved.map();
    EXPECT_NEAR(shown.y(), saved.y(), 1e-5) << moved.map();
    EXPECT_NEAR(shown.yaw(), saved.yaw(), 1e-6) << moved.map();
  }
}

TEST_F(GraphEditTest, AContradictingDragIsShownAsSwitchedOffBeforeItIsSaved) {
  Join("mc", "m", "c", {0, 5, 0}, {-10, 5, 0});
  Join("mc2", "m", "c", {0, -5, 0}, {-10, -5, 0});
  AwaitSolution();
  ASSERT_OK_AND_ASSIGN(v1::PreviewGraphResponse preview, Preview({Move("mc2", "c", {2, 0, 0})}));
  const v1::LinkPointResidual* const dragged = ResidualOf(preview, "mc2");
  ASSERT_NE(dragged, nullptr);
  EXPECT_FALSE(dragged->switched_off_before());
  EXPECT_TRUE(dragged->switched_off_after());
  EXPECT_GT(dragged->chi2_after(), dragged->gate());
  EXPECT_LT(dragged->chi2_before(), 1.0);
  EXPECT_EQ(preview.moved_maps_size(), 0) << "the others outvote it";
  // Suspended beforehand, it contradicts nothing.
  v1::GraphChange suspended;
  suspended.set_suspended(NameOf("mc2"));
  ASSERT_OK_AND_ASSIGN(preview, Preview({Move("mc2", "c", {2, 0, 0}), suspended}));
  EXPECT_FALSE(ResidualOf(preview, "mc2")->switched_off_after());
}

TEST_F(GraphEditTest, ChangesAreMadeTogetherOrNotAtAll) {
  const v1::GraphChange good = Move("mb", "m", {0.1, 0, 0});
  v1::GraphChange stale = Move("bc", "b", {0, 1, 0});
  ASSERT_OK(Change({Move("bc", "b", {0, 0.5, 0})}));
  ASSERT_OK_AND_ASSIGN(const v1::LinkPoint mb, Read("mb"));
  const std::vector<v1::GraphChange> changes = {good, Creation(NameOf("made"), "m", "far"), stale};
  EXPECT_STATUS(Change(changes), absl::StatusCode::kAborted,
                AllOf(HasSubstr("changes[2]"), HasSubstr(NameOf("bc")), HasSubstr("read it again")));
  EXPECT_CODE(Read("made"), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const v1::LinkPoint mb_after, Read("mb"));
  EXPECT_EQ(mb_after.etag(), mb.etag());
  EXPECT_EQ(mb_after.anchors(0).SerializeAsString(), mb.anchors(0).SerializeAsString());
  EXPECT_CODE(Preview(changes), absl::StatusCode::kAborted);
}

TEST_F(GraphEditTest, OfTwoPeopleAtOnceTheSecondIsRefusedWithAllOfItsChanges) {
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    // Both have read the same etags.
    std::vector<v1::GraphChange> mine[2];
    for (int person = 0; person < 2; ++person) {
      mine[person] = {
          Creation(NameOf(fmt::format("p{}-{}", person, round)), "m", "far", {3.0 * round, 10.0 + person, 0}),
          Move("bc", "b", {0, 0.01 * (person + 1), 0})};
    }
    absl::Status status[2];
    std::vector<std::thread> people;
    for (int person = 0; person < 2; ++person) {
      people.emplace_back([&, person] { status[person] = ChangeBy(*connection_, mine[person]).status(); });
    }
    for (std::thread& one : people) one.join();
    ASSERT_NE(status[0].ok(), status[1].ok()) << status[0] << " " << status[1];
    for (int person = 0; person < 2; ++person) {
      const auto made = Read(fmt::format("p{}-{}", person, round));
      if (status[person].ok()) {
        EXPECT_OK(made);
      } else {
        EXPECT_STATUS(status[person], absl::StatusCode::kAborted, HasSubstr(NameOf("bc")));
        EXPECT_CODE(made, absl::StatusCode::kNotFound);
      }
    }
  }
}

TEST_F(GraphEditTest, EveryKindOfChangeIsMadeAndAudited) {
  Join("spare", "m", "far", {0, 20, 0});
  Join("resting", "m", "far", {0, 30, 0});
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("resting"), 0, true));
  v1::GraphChange deleted, suspended, resumed, retagged;
  deleted.set_deleted(NameOf("spare"));
  suspended.set_suspended(NameOf("bc"));
  resumed.set_resumed(NameOf("resting"));
  retagged.mutable_updated()->set_name(NameOf("mb"));
  retagged.mutable_updated()->set_tag("north door");
  retagged.mutable_update_mask()->add_paths("tag");
  const client::Connection ada(connection_->address(), std::chrono::seconds(30), "ada");
  ASSERT_OK_AND_ASSIGN(const v1::ChangeGraphResponse changed,
                       ChangeBy(ada, {Creation("sites/s", "m", "far"), deleted, suspended, resumed, retagged}));
  ASSERT_EQ(changed.link_points_size(), 4);
  EXPECT_EQ(changed.link_points(1).use(), v1::LinkPoint::USE_SUSPENDED);
  EXPECT_EQ(changed.link_points(2).use(), v1::LinkPoint::USE_USED);
  EXPECT_EQ(changed.link_points(3).tag(), "north door");
  EXPECT_EQ(changed.link_points(3).anchors_size(), 2) << "only the mask's fields change";
  EXPECT_OK(Read(changed.link_points(0).name().substr(NameOf("").size())));
  EXPECT_CODE(Read("spare"), absl::StatusCode::kNotFound);
  // Who changed the graph sees it, and the versions tell each change.
  EXPECT_GE(GetGraph().graph_version(), changed.graph_version());
  ASSERT_OK_AND_ASSIGN(const auto versions, graph_store_.ListVersions(Soon(), site_, changed.graph_version() + 1, 5));
  ASSERT_EQ(versions.size(), 5U);
  EXPECT_EQ(versions[0].resource, "linkPoints/mb");
  EXPECT_EQ(versions[3].cause, storage::GraphCause::kLinkPointRemoved);
  for (const storage::GraphVersion& version : versions) EXPECT_EQ(version.actor, "ada");
  std::vector<v1::AuditEntry> entries = Audit();
  std::erase_if(entries, [](const v1::AuditEntry& entry) { return entry.actor() != "ada"; });
  ASSERT_GE(entries.size(), 8U) << "the rows of five link points, and anchors made and removed";
  for (std::size_t i = 0; i < entries.size(); ++i) {
    EXPECT_EQ(entries[i].time().SerializeAsString(), entries[0].time().SerializeAsString());
    if (i == 0) continue;
    EXPECT_GT(std::stoll(entries[i - 1].id()), std::stoll(entries[i].id())) << "the newest first";
  }
}

TEST_F(GraphEditTest, WhatIsLeftOutOfAnUpdateStays) {
  v1::GraphChange change = Move("mb", "m", {});
  change.mutable_updated()->set_environment(v1::Map::ENVIRONMENT_INDOOR);
  change.mutable_updated()->set_kind(v1::LinkPoint::KIND_LIFT);
  change.mutable_updated()->set_direction_map(MapOf("b"));
  change.mutable_updated()->set_state(v1::LinkPoint::STATE_CLOSED);
  ASSERT_OK(Change({change}));
  v1::GraphChange partial;
  partial.mutable_updated()->set_name(NameOf("mb"));
  *partial.mutable_updated()->mutable_anchors() = change.updated().anchors();
  ASSERT_OK_AND_ASSIGN(const v1::ChangeGraphResponse changed, Change({partial}));
  EXPECT_EQ(changed.link_points(0).kind(), v1::LinkPoint::KIND_LIFT);
  EXPECT_EQ(changed.link_points(0).state(), v1::LinkPoint::STATE_CLOSED);
  EXPECT_EQ(changed.link_points(0).environment(), v1::Map::ENVIRONMENT_INDOOR);
  EXPECT_EQ(changed.link_points(0).direction_map(), MapOf("b"));
}

TEST_F(GraphEditTest, RefusesWhatIsWrongNamingTheChange) {
  const auto refused = [&](const std::vector<v1::GraphChange>& changes, absl::StatusCode code,
                           const std::string& text) {
    EXPECT_STATUS(Change(changes), code, HasSubstr(text));
    EXPECT_STATUS(Preview(changes), code, HasSubstr(text));
  };
  const auto invalid = absl::StatusCode::kInvalidArgument;
  const v1::GraphChange good = Move("mb", "m", {});
  refused({}, invalid, "changes is empty");
  refused(std::vector<v1::GraphChange>(101, good), invalid, "at most 100");
  refused({good, v1::GraphChange()}, invalid, "changes[1]: it has no change");
  v1::GraphChange change = Move("bc", "b", {});
  change.mutable_updated()->mutable_anchors(0)->mutable_pose_map_place()->mutable_pose()->set_x(
      std::numeric_limits<double>::quiet_NaN());
  refused({good, change}, invalid, "changes[1]");
  change = Move("bc", "b", {});
  change.mutable_updated()->clear_anchors();
  refused({change}, invalid, "anchors");
  change.mutable_updated()->set_name("sites/other/linkPoints/bc");
  refused({change}, invalid, "sites/other/linkPoints/bc");
  change.mutable_updated()->set_name(NameOf("none"));
  refused({change}, absl::StatusCode::kNotFound, "linkPoints/none");
  refused({good, good}, invalid, "changes[0] changes");
  change = Creation(NameOf("new"), "m", "nowhere");
  refused({change}, absl::StatusCode::kNotFound, "nowhere");
  change = Creation(NameOf("new"), "m", "b", {5, 0, 0});
  refused({change}, absl::StatusCode::kAlreadyExists, NameOf("mb"));
  change.set_force(true);
  EXPECT_OK(Preview({change}));
  change.set_etag("1");
  refused({change}, invalid, "etag");
  refused({Creation(NameOf("mb"), "m", "far")}, absl::StatusCode::kAlreadyExists, NameOf("mb"));
  v1::GraphChange deleted;
  deleted.set_deleted(NameOf("bc"));
  deleted.set_etag("7");
  refused({deleted}, absl::StatusCode::kAborted, NameOf("bc"));
  deleted.set_etag("seven");
  refused({deleted}, invalid, "etag");
  v1::PreviewGraphRequest nowhere;
  nowhere.set_site("sites/none");
  *nowhere.add_changes() = deleted;
  nowhere.mutable_changes(0)->clear_etag();
  nowhere.mutable_changes(0)->set_deleted("sites/none/linkPoints/bc");
  EXPECT_CODE(Call(&Stub::PreviewGraph, nowhere), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing

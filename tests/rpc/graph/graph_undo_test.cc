// SPDX-License-Identifier: Apache-2.0
// Changes of link points that are taken back by what the audit trail tells of them.
#include "client/sdk/editing/graph_undo.h"

#include <string>
#include <vector>

#include "client/sdk/api/paging.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "tests/rpc/graph_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

using LinkPointStub = v1::LinkPointService::Stub;

class GraphUndoTest : public GraphTest {
 protected:
  static std::string NameOf(const std::string& id) { return "sites/s/linkPoints/" + id; }

  v1::LinkPoint Read(const std::string& id) const {
    v1::GetLinkPointRequest request;
    request.set_name(NameOf(id));
    const auto response = Call(&LinkPointStub::GetLinkPoint, request);
    EXPECT_OK(response);
    return response.ok() ? response->link_point() : v1::LinkPoint();
  }
  bool Exists(const std::string& id) const { return link_points_.Get(Soon(), site_, LinkPointId(id)).ok(); }
  // What people can change of it.
  static std::string ContentOf(v1::LinkPoint link_point) {
    link_point.clear_etag();
    link_point.clear_graph_version();
    link_point.clear_update_time();
    link_point.clear_create_time();
    link_point.clear_pose_world_place();
    return link_point.DebugString();
  }
  absl::Status Update(const std::string& id, const std::function<void(v1::LinkPoint&)>& edit) const {
    v1::UpdateLinkPointRequest request;
    *request.mutable_link_point() = Read(id);
    edit(*request.mutable_link_point());
    for (const char* path :
         {"kind", "tag", "anchors", "direction_map", "difficulty", "environment", "state", "state_valid_until"}) {
      request.mutable_update_mask()->add_paths(path);
    }
    return Call(&LinkPointStub::UpdateLinkPoint, request).status();
  }
  // The newest entry of the link point.
  std::string LastEntry(const std::string& id) const {
    v1::ListAuditEntriesRequest request;
    request.set_parent("sites/s");
    request.set_resource(NameOf(id));
    const auto response = Call(&v1::SiteService::Stub::ListAuditEntries, request);
    EXPECT_OK(response);
    return response.ok() && response->entries_size() > 0 ? response->entries(0).id() : "";
  }
  absl::Status Undo(const std::string& entry) const {
    v1::ChangeGraphRequest request;
    request.set_site("sites/s");
    ENFILADE_ASSIGN_OR_RETURN(const auto changes, client::ReadInverse(*connection_, "sites/s", entry));
    request.mutable_changes()->Add(changes.begin(), changes.end());
    return Call(&v1::GraphService::Stub::ChangeGraph, request).status();
  }
};

TEST_F(GraphUndoTest, AnUpdateIsTakenBackAndTheUndoToo) {
  const std::string before = ContentOf(Read("mb"));
  ASSERT_OK(Update("mb", [](v1::LinkPoint& link_point) {
    link_point.mutable_anchors(0)->mutable_pose_map_place()->mutable_pose()->set_x(1.0 / 3.0);
    link_point.mutable_anchors(1)->mutable_pose_map_place()->set_covariance(0, 0.1);
    link_point.set_kind(v1::LinkPoint::KIND_LIFT);
    link_point.set_tag("\"lift\" \\ Ä");
    link_point.set_difficulty(3);
    link_point.set_environment(v1::Map::ENVIRONMENT_INDOOR);
    link_point.set_direction_map("sites/s/maps/b");
    link_point.set_state(v1::LinkPoint::STATE_CLOSED);
    link_point.mutable_state_valid_until()->set_seconds(1'900'000'000);
    link_point.mutable_state_valid_until()->set_nanos(123'456'000);
  }));
  const std::string changed = ContentOf(Read("mb"));
  ASSERT_NE(changed, before);
  ASSERT_OK(Undo(LastEntry("mb")));
  EXPECT_EQ(ContentOf(Read("mb")), before);
  ASSERT_OK(Undo(LastEntry("mb")));
  EXPECT_EQ(ContentOf(Read("mb")), changed);
}

TEST_F(GraphUndoTest, OnlyWhatWasChangedBecomesWhatItWas) {
  const v1::LinkPoint before = Read("mb");
  ASSERT_OK(Update("mb", [](v1::LinkPoint& link_point) {
    link_point.mutable_anchors(0)->mutable_pose_map_place()->mutable_pose()->set_x(6);
  }));
  const std::string moved = LastEntry("mb");
  ASSERT_OK(Update("mb", [](v1::LinkPoint& link_point) { link_point.set_tag("north"); }));
  ASSERT_OK(Undo(moved));
  EXPECT_EQ(Read("mb").anchors(0).SerializeAsString(), before.anchors(0).SerializeAsString());
  EXPECT_EQ(Read("mb").tag(), "north");
}

TEST_F(GraphUndoTest, WhatOthersHaveChangedSinceIsNotOverwritten) {
  const auto move_to = [&](double x) {
    return Update("mb", [x](v1::LinkPoint& link_point) {
      link_point.mutable_anchors(0)->mutable_pose_map_place()->mutable_pose()->set_x(x);
    });
  };
  ASSERT_OK(move_to(6));
  const std::string first = LastEntry("mb");
  ASSERT_OK(move_to(7));
  const std::string second = LastEntry("mb");
  EXPECT_STATUS(Undo(first), absl::StatusCode::kFailedPrecondition, HasSubstr("its anchor in sites/s/maps/m"));
  ASSERT_OK(Undo(second));
  ASSERT_OK(Undo(first));
  EXPECT_EQ(Read("mb").anchors(0).pose_map_place().pose().x(), 5.0);
}

TEST_F(GraphUndoTest, ADeletedOneIsMadeAgainAsItWas) {
  ASSERT_OK(Update("bc", [](v1::LinkPoint& link_point) { link_point.set_tag("east"); }));
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("bc"), 0, true));
  const std::string before = ContentOf(Read("bc"));
  v1::DeleteLinkPointRequest request;
  request.set_name(NameOf("bc"));
  ASSERT_OK(Call(&LinkPointStub::DeleteLinkPoint, request));
  ASSERT_OK(Undo(LastEntry("bc")));
  EXPECT_EQ(ContentOf(Read("bc")), before);
  ASSERT_OK(Undo(LastEntry("bc")));
  EXPECT_FALSE(Exists("bc"));
}

TEST_F(GraphUndoTest, ANewOneIsDeletedUnlessItHasBeenChanged) {
  Join("mf", "m", "far");
  const std::string made = LastEntry("mf");
  const v1::LinkPoint as_made = Read("mf");
  ASSERT_OK(Update("mf", [](v1::LinkPoint& link_point) {
    link_point.mutable_anchors(0)->mutable_pose_map_place()->mutable_pose()->set_y(2);
  }));
  EXPECT_STATUS(Undo(made), absl::StatusCode::kFailedPrecondition, HasSubstr("its anchor"));
  ASSERT_OK(Undo(LastEntry("mf")));
  ASSERT_OK(Undo(made));
  EXPECT_FALSE(Exists("mf"));
}

TEST_F(GraphUndoTest, APromotionAndASuspensionAreTakenBack) {
  storage::StoredLinkPoint candidate;
  candidate.site = site_;
  candidate.point.id = LinkPointId("seen");
  candidate.point.anchors = {{MapId("m"), {1, 9, 0}, graph::DefaultAnchorCovariance()}};
  ASSERT_OK(link_points_.Create(Soon(), candidate, ""));
  ASSERT_OK(link_points_.AddAnchor(Soon(), site_,
                                   {LinkPointId("seen"), 0, {MapId("far"), {}, graph::DefaultAnchorCovariance()}}));
  ASSERT_OK(Undo(LastEntry("seen")));
  EXPECT_EQ(Read("seen").anchors_size(), 1);
  EXPECT_EQ(Read("seen").anchors(0).map(), "sites/s/maps/m");
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("mb"), 0, true));
  ASSERT_OK(Undo(LastEntry("mb")));
  EXPECT_EQ(Read("mb").use(), v1::LinkPoint::USE_USED);
  ASSERT_OK(Undo(LastEntry("mb")));
  EXPECT_EQ(Read("mb").use(), v1::LinkPoint::USE_SUSPENDED);
}

TEST_F(GraphUndoTest, WhatWasChangedTogetherIsTakenBackTogether) {
  const std::string mb = ContentOf(Read("mb"));
  const std::string bc = ContentOf(Read("bc"));
  v1::ChangeGraphRequest request;
  request.set_site("sites/s");
  for (const char* id : {"mb", "bc"}) {
    v1::LinkPoint& updated = *request.add_changes()->mutable_updated();
    updated = Read(id);
    updated.mutable_anchors(0)->mutable_pose_map_place()->mutable_pose()->set_yaw(0.1);
  }
  request.add_changes()->set_suspended(NameOf("bc"));
  ASSERT_OK(Call(&v1::GraphService::Stub::ChangeGraph, request));
  ASSERT_OK(Undo(LastEntry("mb")));
  EXPECT_EQ(ContentOf(Read("mb")), mb);
  EXPECT_EQ(ContentOf(Read("bc")), bc);
}

TEST_F(GraphUndoTest, SaysWhatCannotBeTakenBack) {
  EXPECT_STATUS(Undo("17"), absl::StatusCode::kNotFound, HasSubstr("17"));
  v1::ListAuditEntriesRequest request;
  request.set_parent("sites/s");
  request.set_resource("sites/s/maps/b");
  ASSERT_OK_AND_ASSIGN(const auto entries, Call(&v1::SiteService::Stub::ListAuditEntries, request));
  EXPECT_STATUS(Undo(entries.entries(0).id()), absl::StatusCode::kFailedPrecondition, HasSubstr("link points"));
}

}  // namespace
}  // namespace enfilade::testing

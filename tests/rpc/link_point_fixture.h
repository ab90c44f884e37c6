// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {

// A site "s" with the maps "m" (the root) and "lab", and what link points are made and looked for with.
class LinkPointTest : public ServerTest {
 protected:
  LinkPointTest() { CreateMap("lab", 0); }

  void CreateMap(const std::string& id, int level) {
    v1::CreateMapRequest request;
    request.set_parent("sites/s");
    request.set_map_id(id);
    request.mutable_map()->set_display_name(id);
    request.mutable_map()->set_level(level);
    ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
  }
  static v1::Anchor MakeAnchor(const std::string& map, const Pose2& pose) {
    v1::Anchor anchor;
    anchor.set_map("sites/s/maps/" + map);
    anchor.mutable_pose_map_place()->mutable_pose()->set_x(pose.x);
    anchor.mutable_pose_map_place()->mutable_pose()->set_y(pose.y);
    anchor.mutable_pose_map_place()->mutable_pose()->set_yaw(pose.yaw);
    return anchor;
  }
  static v1::CreateLinkPointRequest MakeRequest(const std::string& id, const std::vector<v1::Anchor>& anchors) {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/s");
    request.set_link_point_id(id);
    request.mutable_link_point()->mutable_anchors()->Add(anchors.begin(), anchors.end());
    return request;
  }
  absl::StatusOr<v1::LinkPoint> Create(const std::string& id, const std::vector<v1::Anchor>& anchors) {
    ENFILADE_ASSIGN_OR_RETURN(const auto response,
                              Call(&v1::LinkPointService::Stub::CreateLinkPoint, MakeRequest(id, anchors)));
    return response.link_point();
  }
  absl::StatusOr<v1::LinkPoint> AddAnchor(const std::string& id, const v1::Anchor& anchor) {
    v1::AddLinkPointAnchorRequest request;
    request.set_name("sites/s/linkPoints/" + id);
    *request.mutable_anchor() = anchor;
    ENFILADE_ASSIGN_OR_RETURN(const auto response, Call(&v1::LinkPointService::Stub::AddLinkPointAnchor, request));
    return response.link_point();
  }
  std::vector<std::string> Find(const v1::FindLinkPointsRequest& request) {
    const auto response = Call(&v1::LinkPointService::Stub::FindLinkPoints, request);
    EXPECT_OK(response);
    std::vector<std::string> ids;
    for (const auto& found : response->found()) {
      ids.push_back(found.link_point().name().substr(std::string("sites/s/linkPoints/").size()));
    }
    return ids;
  }
  absl::Status Attach(const std::string& id, const v1::Evidence& evidence, const std::string& bytes) {
    const auto stub = v1::LinkPointService::NewStub(connection_->channel());
    grpc::ClientContext context;
    v1::AttachEvidenceResponse response;
    const auto writer = stub->AttachEvidence(&context, &response);
    v1::AttachEvidenceRequest request;
    request.mutable_manifest()->set_parent("sites/s/linkPoints/" + id);
    *request.mutable_manifest()->mutable_evidence() = evidence;
    writer->Write(request);
    if (!bytes.empty()) {
      v1::AttachEvidenceRequest chunk;
      *chunk.mutable_chunk()->mutable_blob() = evidence.image().content();
      chunk.mutable_chunk()->set_data(bytes);
      writer->Write(chunk);
    }
    writer->WritesDone();
    return client::FromGrpcStatus(writer->Finish());
  }
};

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/site_of.h"

#include <gtest/gtest.h>

#include <string>

#include "enfilade/v1/graph_service.pb.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "enfilade/v1/link_point_service.pb.h"
#include "enfilade/v1/map_service.pb.h"
#include "enfilade/v1/server_service.pb.h"
#include "enfilade/v1/session_service.pb.h"
#include "enfilade/v1/site_service.pb.h"
#include "google/protobuf/descriptor.h"

namespace enfilade::server {
namespace {

TEST(SiteOfName, ReadsTheSiteOfAnyResourceName) {
  EXPECT_EQ(SiteOfName("sites/hq"), "hq");
  EXPECT_EQ(SiteOfName("sites/hq-2/maps/m/revisions/7"), "hq-2");
  EXPECT_EQ(SiteOfName("sites/hq/"), "hq") << "malformed behind the site";
}

TEST(SiteOfName, IsEmptyForOtherTexts) {
  for (const std::string& name :
       {std::string(), std::string("sites"), std::string("sites/"), std::string("sites//maps/m"),
        std::string("Sites/hq"), std::string("maps/m"), std::string("/sites/hq"), std::string("sites/HQ"),
        std::string("sites/a b"), std::string("sites/\n"), std::string("sites/") + std::string(64, 'a')}) {
    EXPECT_EQ(SiteOfName(name), "") << name;
  }
}

// Sets the field `path` ("map_pose.map") of a message to a resource name of site "hq".
template <typename Request>
std::string SiteIn(const std::string& path, const std::string& name) {
  Request request;
  google::protobuf::Message* message = &request;
  std::string rest = path;
  while (true) {
    const std::size_t dot = rest.find('.');
    const auto* field = message->GetDescriptor()->FindFieldByName(rest.substr(0, dot));
    if (field == nullptr) return "no such field";
    if (dot == std::string::npos) {
      message->GetReflection()->SetString(message, field, name);
      return SiteOf(request);
    }
    message = message->GetReflection()->MutableMessage(message, field);
    rest = rest.substr(dot + 1);
  }
}

TEST(SiteOf, FindsTheResourceNameOfEachKindOfRequest) {
  EXPECT_EQ(SiteIn<v1::GetSiteRequest>("name", "sites/hq"), "hq");
  EXPECT_EQ(SiteIn<v1::UpdateSiteRequest>("site.name", "sites/hq"), "hq");
  EXPECT_EQ(SiteIn<v1::ListMapsRequest>("parent", "sites/hq"), "hq");
  EXPECT_EQ(SiteIn<v1::UpdateMapRequest>("map.name", "sites/hq/maps/m"), "hq");
  EXPECT_EQ(SiteIn<v1::ExportMapRequest>("name", "sites/hq/maps/m"), "hq");
  EXPECT_EQ(SiteIn<v1::ImportMapRequest>("manifest.parent", "sites/hq/maps/m"), "hq");
  EXPECT_EQ(SiteIn<v1::GetGraphRequest>("site", "sites/hq"), "hq");
  EXPECT_EQ(SiteIn<v1::GetGlobalPoseRequest>("robot", "sites/hq/robots/r"), "hq");
  EXPECT_EQ(SiteIn<v1::GetGlobalPoseRequest>("map_pose.map", "sites/hq/maps/m"), "hq");
  EXPECT_EQ(SiteIn<v1::TransformPosesRequest>("source_map", "sites/hq/maps/m"), "hq");
  EXPECT_EQ(SiteIn<v1::FindRoutesRequest>("start_map", "sites/hq/maps/m"), "hq");
  EXPECT_EQ(SiteIn<v1::UpdateLinkPointRequest>("link_point.name", "sites/hq/linkPoints/l"), "hq");
  EXPECT_EQ(SiteIn<v1::AttachEvidenceRequest>("manifest.parent", "sites/hq/linkPoints/l"), "hq");
  EXPECT_EQ(SiteIn<v1::SubmitScanRequest>("session", "sites/hq/sessions/s"), "hq");
  EXPECT_EQ(SiteIn<v1::StreamRecordsRequest>("open.session", "sites/hq/sessions/s"), "hq");
  EXPECT_EQ(SiteIn<v1::CreateSessionRequest>("parent", "sites/hq"), "hq");
}

TEST(SiteOf, IsEmptyIfTheRequestNamesNoSite) {
  EXPECT_EQ(SiteOf(v1::GetServerStatusRequest()), "");
  EXPECT_EQ(SiteOf(v1::ListSitesRequest()), "");
  EXPECT_EQ(SiteOf(v1::GetGlobalPoseRequest()), "");
  EXPECT_EQ(SiteIn<v1::GetMapRequest>("name", "maps/m"), "");
}

TEST(SiteOf, PrefersTheParentToWhatIsInside) {
  v1::CreateSessionRequest request;
  request.set_parent("sites/a");
  request.mutable_session()->set_name("sites/b/sessions/s");
  EXPECT_EQ(SiteOf(request), "a");
}

}  // namespace
}  // namespace enfilade::server

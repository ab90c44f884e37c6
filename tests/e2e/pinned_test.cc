// SPDX-License-Identifier: Apache-2.0
// What people have decided of maps and link points outlasts the surveys of later drives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "client/sdk/api/paging.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "tests/e2e/campus/campus_run.h"
#include "tests/e2e/campus/mapped_state.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

using ::testing::Contains;
using ::testing::Not;
using ::testing::SizeIs;

template <typename Message>
std::vector<std::string> NamesOf(const std::vector<Message>& messages) {
  std::vector<std::string> names;
  for (const Message& message : messages) names.push_back(message.name());
  return names;
}

class Pinned : public ::testing::Test {
 protected:
  void SetUp() override {
    CampusRun run;
    run.campus = "figure1";
    run.robots = {"r1"};
    run.image_hz = 0.0;
    run.cloud_hz = 0.0;
    const CampusResult result = RunCampus(system_, run);
    ASSERT_TRUE(result.comparison.exact) << ::testing::PrintToString(result.comparison.wrong);
    site_ = result.site;
  }

  // The robot drives the same way again. It does not know where it begins.
  void DriveAgain(const std::string& seed) {
    system_.Tool(site_, {"robot", "--campus", "figure1", "--robot", "r1", "--seed", seed, "--image-hz", "0",
                         "--cloud-hz", "0", "--spool", (system_.directory() / ("spool" + seed)).string(), "--wait"});
    ReadWhenQuiet(connection_, site_, {"r1"});
  }

  std::vector<v1::Map> Maps() {
    v1::ListMapsRequest request;
    request.set_parent("sites/" + site_);
    const auto maps =
        client::ListAll(connection_, &v1::MapService::Stub::ListMaps, request, &v1::ListMapsResponse::maps);
    EXPECT_OK(maps);
    return maps.ok() ? *maps : std::vector<v1::Map>();
  }

  std::vector<v1::LinkPoint> LinkPoints() {
    v1::ListLinkPointsRequest request;
    request.set_parent("sites/" + site_);
    request.set_subset(v1::LINK_POINT_SUBSET_LINK_POINTS);
    const auto points = client::ListAll(connection_, &v1::LinkPointService::Stub::ListLinkPoints, request,
                                        &v1::ListLinkPointsResponse::link_points);
    EXPECT_OK(points);
    return points.ok() ? *points : std::vector<v1::LinkPoint>();
  }

  int SessionsIn(const std::string& map) const {
    return std::stoi(system_.Query("SELECT count(*) FROM enfilade.sessions WHERE site_id = '" + site_ +
                                   "' AND map_id = '" + map.substr(map.rfind('/') + 1) + "'"));
  }

  WholeSystem system_{std::vector<std::string>()};
  client::Connection connection_{system_.server().Connect()};
  std::string site_;
};

TEST_F(Pinned, WhatPeopleMergeAndMakeStaysWhenRobotsDriveOn) {
  std::map<std::string, v1::Map::Environment> environments;
  for (const v1::Map& map : Maps()) environments[map.name()] = map.environment();
  ASSERT_THAT(environments, SizeIs(4));
  const std::vector<v1::LinkPoint> points = LinkPoints();
  const auto indoors = std::find_if(points.begin(), points.end(), [&](const v1::LinkPoint& point) {
    return environments.at(point.anchors(0).map()) == v1::Map::ENVIRONMENT_INDOOR &&
           environments.at(point.anchors(1).map()) == v1::Map::ENVIRONMENT_INDOOR;
  });
  ASSERT_NE(indoors, points.end());
  v1::MergeMapsRequest merge;
  merge.set_name(indoors->anchors(0).map());
  merge.set_merged_map(indoors->anchors(1).map());
  const auto merged = connection_.Call(&v1::MapService::Stub::MergeMaps, merge);
  ASSERT_OK(merged);
  EXPECT_TRUE(merged->map().pinned());
  const std::string map = merged->map().name();
  const int sessions = SessionsIn(map);
  ASSERT_THAT(Maps(), SizeIs(3));

  // A hatch 3 m beside a door, which nobody goes through.
  const std::vector<v1::LinkPoint> left = LinkPoints();
  ASSERT_FALSE(left.empty());
  v1::CreateLinkPointRequest create;
  create.set_parent("sites/" + site_);
  create.set_link_point_id("hatch");
  for (const v1::Anchor& anchor : left.front().anchors()) {
    v1::Anchor& added = *create.mutable_link_point()->add_anchors();
    added = anchor;
    v1::Pose2& pose = *added.mutable_pose_map_place()->mutable_pose();
    pose.set_x(pose.x() - 3.0 * std::sin(pose.yaw()));
    pose.set_y(pose.y() + 3.0 * std::cos(pose.yaw()));
  }
  const auto hatch = connection_.Call(&v1::LinkPointService::Stub::CreateLinkPoint, create);
  ASSERT_OK(hatch);
  EXPECT_TRUE(hatch->link_point().pinned());

  DriveAgain("2");
  EXPECT_THAT(Maps(), SizeIs(3));
  EXPECT_THAT(NamesOf(Maps()), Contains(map));
  EXPECT_GT(SessionsIn(map), sessions) << "what robots record in its rooms joins it";
  EXPECT_THAT(NamesOf(LinkPoints()), Contains(hatch->link_point().name()));

  // Given back to surveys, the rooms are two maps after the next drive, and the hatch is gone.
  system_.Tool(site_, {"map", "unpin", map});
  system_.Tool(site_, {"linkpoint", "unpin", "hatch"});
  DriveAgain("3");
  EXPECT_THAT(Maps(), SizeIs(4));
  EXPECT_THAT(NamesOf(LinkPoints()), Not(Contains(hatch->link_point().name())));
}

}  // namespace
}  // namespace enfilade::testing

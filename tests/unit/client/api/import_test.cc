// SPDX-License-Identifier: Apache-2.0
// What imports create, and how they go on after a refusal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "client/import/building_import.h"
#include "client/import/map_manager_import.h"
#include "tests/support/scripted_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using Outcome = ImportLine::Outcome;

class ImportTest : public ::testing::Test {
 protected:
  ImportTest() {
    server_.maps.create_map = [this](const v1::CreateMapRequest& request, v1::CreateMapResponse& response) {
      const std::string display_name = request.map().display_name();
      if (errors_.contains(display_name)) return grpc::Status(errors_[display_name], display_name + " is refused");
      const std::string id = request.map_id().empty() ? "m" + std::to_string(maps_.size()) : request.map_id();
      if (existing_.contains(id) || !names_.insert(display_name).second) {
        return grpc::Status(grpc::StatusCode::ALREADY_EXISTS, "exists");
      }
      maps_.push_back(request);
      response.mutable_map()->set_name("sites/s/maps/" + id);
      return grpc::Status::OK;
    };
    server_.maps.get_map = [this](const v1::GetMapRequest& request, v1::GetMapResponse&) {
      for (const std::string& id : existing_) {
        if (request.name() == "sites/s/maps/" + id) return grpc::Status::OK;
      }
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "no map");
    };
    server_.link_points.create = [this](const v1::CreateLinkPointRequest& request,
                                        v1::CreateLinkPointResponse& response) {
      const std::string tag = request.link_point().tag();
      if (errors_.contains(tag)) return grpc::Status(errors_[tag], tag + " is refused");
      link_points_.push_back(request);
      *response.mutable_link_point() = request.link_point();
      response.mutable_link_point()->set_name("sites/s/linkPoints/" + std::to_string(link_points_.size()));
      return grpc::Status::OK;
    };
    server_.link_points.attach_evidence = [this](grpc::ServerReader<v1::AttachEvidenceRequest>& reader,
                                                 v1::AttachEvidenceResponse&) {
      v1::AttachEvidenceRequest part;
      std::string bytes;
      while (reader.Read(&part)) bytes += part.chunk().data();
      if (bytes == "bad") return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "not a PNG");
      evidence_.push_back(bytes);
      return grpc::Status::OK;
    };
  }

  // "outcome item" of every line.
  std::vector<std::string> Lines() const {
    std::vector<std::string> lines;
    for (const ImportLine& line : report_.lines())
      lines.push_back(std::string(ToString(line.outcome)) + " " + line.item);
    return lines;
  }

  testing::TemporaryDirectory directory_;
  testing::ScriptedServer server_{(directory_.path() / "s").string()};
  const Connection connection_{server_.address(), std::chrono::seconds(20)};
  ImportReport report_;
  std::map<std::string, grpc::StatusCode> errors_;  // by display name or tag
  std::set<std::string> existing_;                  // ids of maps
  std::set<std::string> names_;
  std::vector<v1::CreateMapRequest> maps_;
  std::vector<v1::CreateLinkPointRequest> link_points_;
  std::vector<std::string> evidence_;
};

prior::Building TwoFloors() {
  prior::Building building;
  building.name = "Hotel";
  building.levels = {{"L1", 0, {{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}}, {{"front", {1.0, 2.0, 0.5}}}}, {"L2", 1, {}, {}}};
  building.lifts = {{"A", {{0, {1.0, 1.0, 0.0}}, {1, {2.0, 2.0, 0.0}}}}};
  building.remarks = {{"levels L3", true, "no scale"}, {"doors x", false, "odd"}};
  return building;
}

TEST_F(ImportTest, ABuildingBecomesMapsLiftsAndCandidates) {
  ASSERT_OK(ImportBuilding(connection_, SiteId("s"), TwoFloors(), "Hotel ", {}, report_));
  EXPECT_THAT(Lines(), ElementsAre("refused levels L3", "remark doors x", "taken levels L1", "taken levels L2",
                                   "taken lifts A", "taken levels L1 doors front"));
  EXPECT_EQ(report_.taken(), 4);
  EXPECT_EQ(report_.refused(), 1);
  ASSERT_THAT(maps_, SizeIs(2));
  EXPECT_EQ(maps_[0].map().display_name(), "Hotel L1");
  EXPECT_EQ(maps_[0].map().outline().corners_size(), 3);
  EXPECT_EQ(maps_[1].map().level(), 1);
  ASSERT_THAT(link_points_, SizeIs(2));
  EXPECT_EQ(link_points_[0].link_point().kind(), v1::LinkPoint::KIND_LIFT);
  ASSERT_EQ(link_points_[0].link_point().anchors_size(), 2);
  EXPECT_EQ(link_points_[0].link_point().anchors(1).map(), "sites/s/maps/m1");
  EXPECT_EQ(link_points_[1].link_point().anchors(0).pose_map_place().pose().yaw(), 0.5);
  EXPECT_THAT(report_.lines().back().remark, HasSubstr("candidate"));
}

TEST_F(ImportTest, DrawnLevelsAreFirstRevisions) {
  std::vector<std::string> drawn;
  server_.maps.import_map = [&drawn](grpc::ServerReader<v1::ImportMapRequest>& reader, v1::ImportMapResponse&) {
    v1::ImportMapRequest part;
    while (reader.Read(&part)) {
      if (part.has_manifest()) drawn.push_back(part.manifest().parent() + " " + part.manifest().files(0).name());
    }
    return drawn.size() < 2 ? grpc::Status::OK : grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "too large");
  };
  const std::vector<LevelDrawing> drawings = {{{"L1.yaml", "image: L1.png"}, {"L1.png", "pixels"}},
                                              {{"L2.yaml", "image: L2.png"}, {"L2.png", "pixels"}}};
  ASSERT_OK(ImportBuilding(connection_, SiteId("s"), TwoFloors(), "Hotel ", drawings, report_));
  EXPECT_THAT(drawn, ElementsAre("sites/s/maps/m0 L1.yaml", "sites/s/maps/m1 L2.yaml"));
  EXPECT_THAT(Lines(), ::testing::Contains("remark levels L2"));
  EXPECT_EQ(report_.taken(), 4);
}

TEST_F(ImportTest, WhatHangsOnARefusedLevelIsLeftOut) {
  errors_["L1"] = grpc::StatusCode::INVALID_ARGUMENT;
  ASSERT_OK(ImportBuilding(connection_, SiteId("s"), TwoFloors(), "", {}, report_));
  ASSERT_THAT(link_points_, SizeIs(1)) << "the lift, with its upper stop";
  EXPECT_EQ(link_points_[0].link_point().anchors_size(), 1);
  EXPECT_EQ(report_.lines().back().outcome, Outcome::kRefused);
  EXPECT_THAT(report_.lines().back().remark, HasSubstr("none of its levels"));
}

TEST_F(ImportTest, AServerThatIsAwayEndsTheImportWithWhatWasDone) {
  for (const auto code :
       {grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::PERMISSION_DENIED, grpc::StatusCode::DEADLINE_EXCEEDED}) {
    report_ = ImportReport();
    names_.clear();
    errors_ = {{"L2", code}};
    EXPECT_CODE(ImportBuilding(connection_, SiteId("s"), TwoFloors(), "", {}, report_),
                static_cast<absl::StatusCode>(code));
    EXPECT_EQ(report_.taken(), 1);
    EXPECT_TRUE(link_points_.empty());
  }
  for (const auto code :
       {absl::StatusCode::kInvalidArgument, absl::StatusCode::kAlreadyExists, absl::StatusCode::kOk}) {
    EXPECT_FALSE(EndsImport(absl::Status(code, ""))) << code;
  }
}

sources::MapManagerContent TwoMaps() {
  sources::MapManagerContent content;
  content.maps = {{1, "Hall", true}, {-2, "", false}};
  sources::MapManagerPlace door;
  door.id = 7;
  door.tag = "door";
  door.anchors = {{1, {1.0, 2.0, 0.5}}, {-2, {0.0, 0.0, 0.0}}};
  door.direction = -2;
  door.difficulty = 3;
  door.indoor = false;
  door.front_image = "front";
  door.cloud = "cloud";
  sources::MapManagerPlace candidate;
  candidate.id = 2;
  candidate.candidate = true;
  candidate.anchors = {{1, {3.0, 0.0, 0.0}}};
  candidate.rear_image = "bad";
  content.places = {door, candidate};
  return content;
}

TEST_F(ImportTest, ADatabaseKeepsItsIdsDirectionsAndEvidence) {
  ASSERT_OK(ImportMapManager(connection_, SiteId("s"), TwoMaps(), report_));
  ASSERT_THAT(maps_, SizeIs(2));
  EXPECT_EQ(maps_[0].map_id(), "map-1");
  EXPECT_EQ(maps_[1].map_id(), "map-minus-2");
  EXPECT_EQ(maps_[1].map().display_name(), "map-minus-2") << "a map without a name";
  EXPECT_EQ(maps_[1].map().environment(), v1::Map::ENVIRONMENT_OUTDOOR);
  ASSERT_THAT(link_points_, SizeIs(2));
  EXPECT_EQ(link_points_[0].link_point_id(), "linkpoint-7");
  EXPECT_EQ(link_points_[0].link_point().direction_map(), "sites/s/maps/map-minus-2");
  EXPECT_EQ(link_points_[0].link_point().difficulty(), 3);
  EXPECT_EQ(link_points_[0].link_point().environment(), v1::Map::ENVIRONMENT_OUTDOOR);
  EXPECT_EQ(link_points_[1].link_point_id(), "candidate-2");
  EXPECT_THAT(evidence_, ElementsAre("front", "cloud"));
  EXPECT_THAT(Lines(), ElementsAre("taken MAPS 1", "taken MAPS -2", "taken LINKPOINTS 7", "taken LINKPOINTCANDIDATES 2",
                                   "remark LINKPOINTCANDIDATES 2"));
  EXPECT_THAT(report_.lines().back().remark, HasSubstr("rear image was refused: not a PNG"));
}

TEST_F(ImportTest, AMapThatExistsIsJoinedAndASharedNameGetsItsNumber) {
  existing_ = {"map-1"};
  sources::MapManagerContent content = TwoMaps();
  content.maps[1].name = "Annex";
  names_ = {"Annex"};
  ASSERT_OK(ImportMapManager(connection_, SiteId("s"), content, report_));
  EXPECT_EQ(report_.lines()[0].outcome, Outcome::kRefused);
  EXPECT_THAT(report_.lines()[0].remark, HasSubstr("exists already"));
  ASSERT_THAT(maps_, SizeIs(1));
  EXPECT_EQ(maps_[0].map().display_name(), "Annex (-2)");
  EXPECT_THAT(report_.lines()[1].remark, HasSubstr("\"Annex\" was taken"));
  EXPECT_EQ(link_points_[0].link_point().anchors(0).map(), "sites/s/maps/map-1");
}

TEST_F(ImportTest, APlaceInAMapThatWasRefusedIsRefused) {
  errors_["Hall"] = grpc::StatusCode::INVALID_ARGUMENT;
  ASSERT_OK(ImportMapManager(connection_, SiteId("s"), TwoMaps(), report_));
  EXPECT_TRUE(link_points_.empty());
  EXPECT_EQ(report_.refused(), 3);
  EXPECT_THAT(report_.lines().back().remark, HasSubstr("map 1 was not taken"));
}

}  // namespace
}  // namespace enfilade::client

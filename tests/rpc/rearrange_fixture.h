// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/simulation.h"
#include "core/grid/overlay.h"
#include "core/slam/mapper/log_mapper.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "server/app/mapping/raster_revision.h"
#include "storage/postgres/graph/graph_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {

// A drive through the simulated rooms in two parts, and where the second one begins in the frame of the first.
struct TwoParts {
  std::vector<sensor::Record> first, second;
  Pose2 T_first_second;
};

inline std::vector<sensor::Record> Numbered(std::vector<sensor::Record> records) {
  for (std::size_t i = 0; i < records.size(); ++i) records[i].sequence = static_cast<std::int64_t>(i) + 1;
  return records;
}

inline const TwoParts& Drive() {
  static const TwoParts parts = [] {
    simulator::SimulationOptions options = simulator::RoomsOptions();
    options.seed = 18;
    const auto drive = simulator::SimulateRooms(options);
    EXPECT_OK(drive);
    std::vector<sensor::Record> records;
    for (const simulator::SimulatedRecord& entry : drive->records) {
      std::visit([&](const auto& payload) { records.push_back({0, payload}); }, entry.payload);
    }
    const auto cut = records.begin() + static_cast<std::ptrdiff_t>(records.size() * 3 / 10);
    TwoParts two{Numbered({records.begin(), cut}), Numbered({cut, records.end()}), {}};
    slam::LogMapper whole({}, slam::SlamOptions());
    for (const sensor::Record& record : Numbered(records)) whole.Add(record);
    whole.Finish();
    slam::SlamMap map;
    map.Apply(whole.TakeDelta());
    TimeNs begin = 0;
    for (const sensor::Record& record : two.second) {
      if (const auto* scan = std::get_if<sensor::LaserScan>(&record.payload); scan != nullptr && begin == 0) {
        begin = scan->time;
      }
    }
    const std::vector<slam::StampedPose> trajectory = slam::TrajectoryOf(map);
    two.T_first_second = std::min_element(trajectory.begin(), trajectory.end(), [&](const auto& a, const auto& b) {
                           return std::abs(a.time - begin) < std::abs(b.time - begin);
                         })->T_map_robot;
    return two;
  }();
  return parts;
}

class RearrangeTest : public ServerTest {
 protected:
  // The first part in map "m", the second one in map "m2"; a link point says where m2 lies in m.
  void MapBoth() {
    v1::CreateMapRequest request;
    request.set_parent("sites/s");
    request.set_map_id("m2");
    request.mutable_map()->set_display_name("Second part");
    ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
    first_ = CreateSession(true);
    Map(first_, Drive().first);
    second_ = CreateSessionIn("sites/s/maps/m2");
    Map(second_, Drive().second);
    Link("between", Drive().T_first_second, {});
  }
  std::string CreateSessionIn(const std::string& map) { return CreateSessionAt(map, std::nullopt); }
  // `entry`: where the robot is in the map, well known.
  std::string CreateSessionAt(const std::string& map, const std::optional<Pose2>& entry) {
    v1::CreateSessionRequest request;
    request.set_parent("sites/s");
    request.mutable_session()->set_robot("sites/s/robots/r");
    request.mutable_session()->set_map(map);
    if (entry) {
      const Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal();
      *request.mutable_session()->mutable_entry()->mutable_pose_map_robot() =
          convert::ToProto(PoseWithCovariance{*entry, covariance});
    }
    const auto response = Call(&v1::SessionService::Stub::CreateSession, request);
    EXPECT_OK(response);
    return response.ok() ? response->session().name() : "";
  }
  void Map(const std::string& session, const std::vector<sensor::Record>& log) {
    TestStream stream(*connection_, session);
    std::vector<v1::Record> batch;
    for (const sensor::Record& record : log) {
      batch.push_back(convert::ToProto(record));
      if (batch.size() < 200 && &record != &log.back()) continue;
      ASSERT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    ASSERT_TRUE(stream.AwaitAcknowledged(static_cast<std::int64_t>(log.size())));
    ASSERT_OK(FinishSession(session, static_cast<std::int64_t>(log.size())));
    AwaitState(session, v1::Session::STATE_MAPPED);
  }
  void Link(const std::string& id, const Pose2& in_m, const Pose2& in_m2) {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/s");
    request.set_link_point_id(id);
    request.mutable_link_point()->set_kind(v1::LinkPoint::KIND_DOOR);
    for (const auto& [map, pose] : {std::pair("sites/s/maps/m", in_m), std::pair("sites/s/maps/m2", in_m2)}) {
      v1::Anchor& anchor = *request.mutable_link_point()->add_anchors();
      anchor.set_map(map);
      *anchor.mutable_pose_map_place() = convert::ToProto(PoseWithCovariance{pose, graph::DefaultAnchorCovariance()});
    }
    ASSERT_OK(Call(&v1::LinkPointService::Stub::CreateLinkPoint, request));
  }

  absl::StatusOr<v1::MergeMapsResponse> Merge(const std::string& kept = "m", const std::string& merged = "m2") {
    v1::MergeMapsRequest request;
    request.set_name("sites/s/maps/" + kept);
    request.set_merged_map("sites/s/maps/" + merged);
    return Call(&v1::MapService::Stub::MergeMaps, request);
  }
  absl::StatusOr<v1::UndoRearrangementResponse> Undo(const std::string& name) {
    v1::UndoRearrangementRequest request;
    request.set_name(name);
    return Call(&v1::MapService::Stub::UndoRearrangement, request);
  }
  v1::Map GetMap(const std::string& id) {
    v1::GetMapRequest request;
    request.set_name("sites/s/maps/" + id);
    const auto response = Call(&v1::MapService::Stub::GetMap, request);
    EXPECT_OK(response);
    return response.ok() ? response->map() : v1::Map();
  }

  // Of the graph: what watchers are told of.
  int CountRearrangedVersions() {
    v1::ListGraphVersionsRequest request;
    request.set_parent("sites/s");
    request.set_page_size(1000);
    const auto response = Call(&v1::GraphService::Stub::ListGraphVersions, request);
    EXPECT_OK(response);
    if (!response.ok()) return -1;
    const auto& versions = response->graph_versions();
    return static_cast<int>(std::count_if(versions.begin(), versions.end(), [](const v1::GraphVersion& version) {
      return version.cause() == v1::GraphVersion::CAUSE_REARRANGED;
    }));
  }
  std::vector<slam::StampedPose> Trajectory(const std::string& session) {
    const auto mapping = storage::postgres::MappingStore(*pool_).ReadTrajectory(Soon(), site_, IdOf(session));
    EXPECT_OK(mapping);
    return mapping.ok() ? mapping->poses : std::vector<slam::StampedPose>();
  }
  std::vector<Pose2> WorldTrajectory(const std::string& session) {
    const std::string map = GetSession(session).map();
    const auto places = storage::postgres::GraphStore(*pool_).GetPlaces(Soon(), site_, {MapId(map.substr(13))});
    EXPECT_OK(places);
    EXPECT_THAT(*places, ::testing::SizeIs(1));
    std::vector<Pose2> world;
    for (const slam::StampedPose& pose : Trajectory(session)) {
      world.push_back(places->front().T_world_map.pose * pose.T_map_robot);
    }
    return world;
  }
  grid::OccupancyGrid Published(const std::string& map) {
    const storage::postgres::RevisionStore revisions(*pool_);
    const auto revision = revisions.Get(Soon(), site_, MapId(map), 0);
    EXPECT_OK(revision);
    const auto raster = server::ReadRaster(Soon(), revisions, *revision);
    EXPECT_OK(raster);
    return grid::ResampleToLattice(grid::ToOccupancyGrid(*raster), 0.05).value();
  }
  std::string HashOf(const std::string& map) {
    const auto revision = storage::postgres::RevisionStore(*pool_).Get(Soon(), site_, MapId(map), 0);
    EXPECT_OK(revision);
    return revision->content_sha256;
  }
  static SessionId IdOf(const std::string& name) { return SessionId(name.substr(name.rfind('/') + 1)); }

  const SiteId site_{"s"};
  std::string first_, second_;
};

}  // namespace enfilade::testing

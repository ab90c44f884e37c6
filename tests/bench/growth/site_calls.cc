// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/growth/site_calls.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <regex>
#include <stdexcept>
#include <thread>

#include "client/sdk/uplink/session_setup.h"
#include "core/base/uuid.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "fmt/format.h"
#include "proto/convert/record.h"
#include "tests/bench/growth/big_site.h"
#include "tests/bench/support/load_generator.h"

namespace enfilade::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kSearchRadius = 20.0;  // m
constexpr int kBatchScans = 5;
constexpr auto kVerdictLimit = std::chrono::seconds(120);
constexpr auto kPoll = std::chrono::milliseconds(2);

template <typename Service, typename Request, typename Response>
Response Must(const client::Connection& connection,
              grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
              const Request& request) {
  auto response = connection.Call(method, request);
  if (!response.ok()) throw std::runtime_error(response.status().ToString());
  return *std::move(response);
}

void AddAnchor(v1::LinkPoint& point, const std::string& map, double x) {
  v1::Anchor& anchor = *point.add_anchors();
  anchor.set_map(map);
  anchor.mutable_pose_map_place()->mutable_pose()->set_x(x);
  for (int i = 0; i < 9; ++i) anchor.mutable_pose_map_place()->add_covariance(i % 4 == 0 ? 0.003 : 0.0);
}

}  // namespace

SiteCalls::SiteCalls(BenchSystem& system, std::string site, int maps)
    : system_(system),
      connection_(system.server().Connect()),
      site_(std::move(site)),
      parent_("sites/" + site_),
      maps_(maps) {
  v1::CreateRobotRequest robot;
  robot.set_parent(parent_);
  robot.set_robot_id("robot");
  robot.mutable_robot()->set_display_name("robot");
  const auto created = connection_.Call(&v1::RobotService::Stub::CreateRobot, robot);
  if (!created.ok() && !absl::IsAlreadyExists(created.status())) throw std::runtime_error(created.status().ToString());
  Settle();
}

std::vector<double> SiteCalls::Time(int count, const std::function<void(int)>& call) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    const Clock::time_point begin = Clock::now();
    call(i);
    times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  }
  return times;
}

std::string SiteCalls::RandomRoom() {
  random_ = random_ * 6364136223846793005ULL + 1442695040888963407ULL;
  return fmt::format("{}/maps/room-{}", parent_, (random_ >> 33) % static_cast<std::uint64_t>(maps_));
}

std::string SiteCalls::CreateSession(const std::string& robot) {
  v1::CreateSessionRequest request;
  request.set_parent(parent_);
  request.mutable_session()->set_robot(parent_ + "/robots/" + robot);
  return Must(connection_, &v1::SessionService::Stub::CreateSession, request).session().name();
}

std::vector<double> SiteCalls::GetSite(int count) {
  v1::GetSiteRequest request;
  request.set_name(parent_);
  return Time(count, [&](int) { Must(connection_, &v1::SiteService::Stub::GetSite, request); });
}

std::vector<double> SiteCalls::FindLinkPoints(int count) {
  v1::FindLinkPointsRequest request;
  request.set_parent(parent_);
  request.set_radius_m(kSearchRadius);
  return Time(count, [&](int i) {
    const RoomPlace place = PlaceOfRoom(static_cast<int>(i * 7919LL % maps_), maps_);
    request.mutable_point_world()->set_x(place.x);
    request.mutable_point_world()->set_y(place.y);
    Must(connection_, &v1::LinkPointService::Stub::FindLinkPoints, request);
  });
}

std::vector<double> SiteCalls::GetGlobalPose(int count) {
  v1::GetGlobalPoseRequest request;
  request.mutable_map_pose()->mutable_pose_map_robot()->mutable_pose();
  return Time(count, [&](int) {
    request.mutable_map_pose()->set_map(RandomRoom());
    Must(connection_, &v1::GraphService::Stub::GetGlobalPose, request);
  });
}

std::vector<double> SiteCalls::SubmitScan(int count) {
  const std::vector<sensor::Record> scans = RandomScans(count, 3);
  v1::SubmitScanRequest request;
  request.set_session(CreateSession("robot"));
  return Time(count, [&](int i) {
    const v1::Record record = convert::ToProto(scans[static_cast<std::size_t>(i)]);
    request.set_sequence(i + 1);
    *request.mutable_laser_scan() = record.laser_scan();
    Must(connection_, &v1::IngestService::Stub::SubmitScan, request);
  });
}

std::vector<double> SiteCalls::StreamRecords(int count) {
  const std::vector<sensor::Record> scans = RandomScans(count * kBatchScans, 4);
  const auto stub = v1::IngestService::NewStub(connection_.channel());
  grpc::ClientContext context;
  const auto stream = stub->StreamRecords(&context);
  v1::StreamRecordsRequest open;
  open.mutable_open()->set_session(CreateSession("robot"));
  stream->Write(open);
  std::vector<double> times = Time(count, [&](int i) {
    v1::StreamRecordsRequest request;
    for (int k = 0; k < kBatchScans; ++k) {
      *request.mutable_batch()->add_records() = convert::ToProto(scans[static_cast<std::size_t>(i * kBatchScans + k)]);
    }
    const std::int64_t last = (i + 1) * kBatchScans;
    bool done = !stream->Write(request);
    for (v1::StreamRecordsResponse response; !done && stream->Read(&response);) {
      done = response.has_acknowledgement() && response.acknowledgement().acknowledged_sequence() >= last;
    }
    if (!done) throw std::runtime_error("the stream ended");
  });
  stream->WritesDone();
  stream->Finish();
  return times;
}

std::vector<double> SiteCalls::NewRoom(int count) {
  return Time(count, [&](int) {
    v1::CreateMapRequest map;
    map.set_parent(parent_);
    map.mutable_map()->set_display_name(fmt::format("new room {}", ++created_));
    const std::string name = Must(connection_, &v1::MapService::Stub::CreateMap, map).map().name();
    v1::CreateLinkPointRequest door;
    door.set_parent(parent_);
    door.mutable_link_point()->set_kind(v1::LinkPoint::KIND_DOOR);
    // Beside all doors of the room and those of other new ones.
    AddAnchor(*door.mutable_link_point(), RandomRoom(), 1.0 + 0.01 * created_);
    AddAnchor(*door.mutable_link_point(), name, 0.0);
    Must(connection_, &v1::LinkPointService::Stub::CreateLinkPoint, door);
  });
}

std::vector<double> SiteCalls::PoseAfterChange(int count) {
  v1::GetGlobalPoseRequest ask;
  ask.mutable_map_pose()->set_map(fmt::format("{}/maps/room-{}", parent_, maps_ - 1));
  ask.mutable_map_pose()->mutable_pose_map_robot()->mutable_pose();
  std::vector<v1::LinkPoint> points;
  for (int i = 0; i < count; ++i) {
    v1::GetLinkPointRequest get;
    const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(maps_))));
    get.set_name(fmt::format("{}/linkPoints/above-{}", parent_, static_cast<int>(i * 7919LL % (maps_ - columns))));
    points.push_back(Must(connection_, &v1::LinkPointService::Stub::GetLinkPoint, get).link_point());
  }
  std::vector<double> times;
  for (v1::LinkPoint& point : points) {
    v1::UpdateLinkPointRequest update;
    v1::Pose2& pose = *point.mutable_anchors(0)->mutable_pose_map_place()->mutable_pose();
    pose.set_x(pose.x() + 0.001);
    *update.mutable_link_point() = point;
    update.mutable_link_point()->clear_etag();
    update.mutable_update_mask()->add_paths("anchors");
    const std::int64_t version =
        Must(connection_, &v1::LinkPointService::Stub::UpdateLinkPoint, update).link_point().graph_version();
    const Clock::time_point changed = Clock::now();
    while (Must(connection_, &v1::GraphService::Stub::GetGlobalPose, ask).global_pose().graph_version() < version) {
      std::this_thread::sleep_for(kPoll);
    }
    times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - changed).count());
  }
  return times;
}

std::vector<double> SiteCalls::DoorVerdict(const RecordedDrive& drive, int sessions) {
  const auto stub = v1::IngestService::NewStub(connection_.channel());
  std::map<SessionId, SessionId> ids;
  for (const RecordedSession& recorded : drive.sessions) {
    if (recorded.batches.empty() || static_cast<int>(ids.size()) == sessions) continue;
    client::SpoolSession session = recorded.session;
    session.site = SiteId(site_);
    session.robot = RobotId("robot");
    session.id = SessionId(NewUuid());
    session.request_id = NewUuid();
    ids.emplace(recorded.session.id, session.id);
    if (session.entry.previous) {
      session.entry.previous = ids.at(*session.entry.previous);
    } else {
      session.map = fmt::format("room-{}", maps_ / 2);
      session.entry.T_map_robot = PoseWithCovariance{};
    }
    const auto created = client::EnsureSession(connection_, session, true);
    if (!created.ok()) throw std::runtime_error(created.status().ToString());
    grpc::ClientContext context;
    const auto stream = stub->StreamRecords(&context);
    v1::StreamRecordsRequest open;
    open.mutable_open()->set_session(created->name());
    stream->Write(open);
    for (const DueBatch& batch : recorded.batches) stream->Write(batch.request);
    stream->WritesDone();
    for (v1::StreamRecordsResponse response; stream->Read(&response);) {
    }
    if (const grpc::Status status = stream->Finish(); !status.ok()) throw std::runtime_error(status.error_message());
    session.last_sequence = recorded.batches.back().last_sequence;
    const auto finished = client::FinishSession(connection_, session);
    if (!finished.ok()) throw std::runtime_error(finished.status().ToString());
  }
  // What the server says that each took. The last session's passage is judged when its doors are.
  std::vector<double> times;
  const Clock::time_point limit = Clock::now() + kVerdictLimit;
  std::size_t judged = 0;
  while (judged + 1 < ids.size()) {
    if (Clock::now() > limit) throw std::runtime_error("the doors are not judged in time");
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    times.clear();
    judged = 0;
    std::ifstream log(system_.server().log());
    const std::regex verdict(R"(door \d+ of session ([-0-9a-f]+): link point \w+ in (\d+) ms)");
    std::smatch match;
    for (std::string line; std::getline(log, line);) {
      if (!std::regex_search(line, match, verdict)) continue;
      const std::string id = match[1];
      const bool ours =
          std::any_of(ids.begin(), ids.end(), [&](const auto& pair) { return pair.second.value() == id; });
      if (!ours) continue;
      ++judged;
      times.push_back(std::stod(match[2]));
    }
  }
  return times;
}

}  // namespace enfilade::bench

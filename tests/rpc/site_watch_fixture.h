// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "enfilade/v1/watch_service.grpc.pb.h"
#include "storage/postgres/maps/revision_store.h"
#include "tests/rpc/graph_fixture.h"

namespace enfilade::testing {

// A client that keeps what a stream of WatchSite tells, as a viewer does.
class SiteViewer {
 public:
  SiteViewer(const client::Connection& connection, const v1::WatchSiteRequest& request)
      : stub_(v1::WatchService::NewStub(connection.channel())), stream_(stub_->WatchSite(&context_, request)) {}
  ~SiteViewer() {
    context_.TryCancel();
    if (!finished_) Finish();
  }

  // The next message. False at the end of the stream.
  bool Read() {
    if (!stream_->Read(&last_)) return false;
    if (last_.start().reset()) Forget();
    was_reset = was_reset || last_.start().reset();
    for (const auto& names : {last_.graph().removed_maps(), last_.graph().removed_link_points(),
                              last_.removed_sessions(), last_.removed_robots()}) {
      removed.insert(names.begin(), names.end());
    }
    for (const std::string& map : last_.graph().removed_maps()) maps.erase(map);
    for (const std::string& link_point : last_.graph().removed_link_points()) link_points.erase(link_point);
    for (const v1::GraphMap& map : last_.graph().maps()) maps[map.map()] = map;
    for (const auto& link_point : last_.graph().link_points()) link_points[link_point.link_point()] = link_point;
    for (const v1::MapRasterState& raster : last_.rasters()) rasters[raster.map()] = raster;
    for (const std::string& session : last_.removed_sessions()) sessions.erase(session);
    for (const v1::SessionState& session : last_.sessions()) sessions[session.session()] = session;
    for (const std::string& robot : last_.removed_robots()) robots.erase(robot);
    for (const v1::RobotState& robot : last_.robots()) robots[robot.robot()] = robot;
    items += CountItems(last_);
    if (!last_.resume_token().empty()) token = last_.resume_token();
    return true;
  }
  template <typename Done>
  void ReadUntil(const Done& done) {
    while (!done()) {
      if (!Read()) {
        ADD_FAILURE() << "the stream ended: " << Finish().error_message();
        return;
      }
    }
  }
  // After the rest of the stream.
  grpc::Status Finish() {
    while (stream_->Read(&last_)) {
    }
    finished_ = true;
    return stream_->Finish();
  }
  const v1::WatchSiteResponse& last() const { return last_; }

  static int CountItems(const v1::WatchSiteResponse& message) {
    return message.graph().maps_size() + message.graph().link_points_size() + message.graph().removed_maps_size() +
           message.graph().removed_link_points_size() + message.rasters_size() + message.sessions_size() +
           message.removed_sessions_size() + message.robots_size() + message.removed_robots_size();
  }

  std::map<std::string, v1::GraphMap> maps;
  std::map<std::string, v1::GraphLinkPoint> link_points;
  std::map<std::string, v1::MapRasterState> rasters;
  std::map<std::string, v1::SessionState> sessions;
  std::map<std::string, v1::RobotState> robots;
  std::set<std::string> removed;
  std::string token;
  bool was_reset = false;
  int items = 0;  // told so far

 private:
  void Forget() {
    maps.clear();
    link_points.clear();
    rasters.clear();
    sessions.clear();
    robots.clear();
  }

  std::unique_ptr<v1::WatchService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::WatchSiteResponse>> stream_;
  v1::WatchSiteResponse last_;
  bool finished_ = false;
};

class SiteWatchTest : public GraphTest {
 protected:
  static v1::WatchSiteRequest Request(const std::string& token = "") {
    v1::WatchSiteRequest request;
    request.set_parent("sites/s");
    request.set_rate_hz(20.0);
    request.set_resume_token(token);
    return request;
  }
  SiteViewer Watch(const std::string& token = "") const { return SiteViewer(*connection_, Request(token)); }

  void AddRevision(const std::string& map) {
    storage::NewRevision revision;
    revision.source = storage::RevisionSource::kImport;
    revision.geometry = {0.05, {}, 8, 8};
    revision.raster_header = "header";
    revision.content_sha256 = std::string(31, 'c') + static_cast<char>('a' + revision_++);
    EXPECT_OK(revisions_.Add(Soon(), site_, MapId(map), revision, {}));
  }

  int revision_ = 0;
  const storage::postgres::RevisionStore revisions_{*pool_};
};

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/sha256.h"
#include "core/closure/door_action.h"
#include "server/app/closure/door_closures.h"
#include "server/app/graph/graph_optimizer.h"
#include "server/app/mapping/mapping.h"
#include "storage/postgres/graph/graph_store.h"
#include "storage/postgres/graph/link_point_store.h"
#include "storage/postgres/graph/robot_pose_store.h"
#include "storage/postgres/graph/site_lease_store.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/map_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "storage/postgres/sessions/record_store.h"
#include "storage/postgres/sessions/session_store.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/door_drive.h"
#include "tests/support/slowdown.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {

// The server's workers without gRPC: mapping, the graph and its optimisation, closures at doors.
class Workers {
 public:
  Workers(storage::postgres::Pool& pool, const closure::DoorClosureOptions& options)
      : pool_(pool), metrics_(*server::Metrics::Create("")), options_(options) {
    mapping_.emplace(
        server::ServerOptions::Mapping{}, slam::SlamOptions(),
        server::SessionMappingStores{mappings_, records_, sessions_, blobs_, revisions_, robot_poses_, maps_},
        *metrics_, [this] { wake_.Wake(); });
    closures_.emplace(options_,
                      server::DoorClosureStores{sessions_, records_, mappings_, blobs_, features_, maps_, link_points_,
                                                verdicts_, leases_},
                      graphs_, wake_,
                      server::DoorClosures::Listeners{.entered = [this] { mapping_->Wake(); }, .judged = [] {}});
  }

  server::SiteGraphs& graphs() { return graphs_; }

 private:
  storage::postgres::Pool& pool_;
  const storage::postgres::SessionStore sessions_{pool_};
  const storage::postgres::RecordStore records_{pool_};
  const storage::postgres::MappingStore mappings_{pool_};
  const storage::postgres::BlobStore blobs_{pool_};
  const storage::FeatureStore features_{pool_};
  const storage::postgres::MapStore maps_{pool_};
  const storage::postgres::RevisionStore revisions_{pool_};
  const storage::postgres::RobotPoseStore robot_poses_{pool_};
  const storage::postgres::LinkPointStore link_points_{pool_};
  const storage::DoorVerdictStore verdicts_{pool_};
  const storage::postgres::SiteLeaseStore leases_{pool_, storage::SiteRight::kChange};
  const storage::postgres::SiteLeaseStore solver_leases_{pool_, storage::SiteRight::kSolve};
  const storage::postgres::GraphStore graph_store_{pool_};
  const std::unique_ptr<server::Metrics> metrics_;
  const closure::DoorClosureOptions options_;
  server::WakeSignal wake_;
  server::ChangedSites changed_;
  server::SiteGraphs graphs_{graph_store_, changed_};
  server::GraphOptimizer optimizer_{graph_store_, {solver_leases_, leases_}, graphs_, changed_};
  std::optional<server::Mapping> mapping_;
  std::optional<server::DoorClosures> closures_;
};

class DoorClosuresTest : public StoreTest {
 protected:
  DoorClosuresTest() { Restart(); }

  void Restart() {
    workers_.reset();
    workers_ = std::make_unique<Workers>(*pool_, options_);
  }

  // Sends a session into `map` or, without one, after `previous`, with all its records, and finishes it.
  SessionId Send(const DrivenSession& driven, const std::optional<MapId>& map, const std::optional<SessionId>& previous,
                 const std::optional<PoseWithCovariance>& T_map_robot = {}) {
    storage::Session session = MakeSession(site_, SessionId("s" + std::to_string(++sessions_made_)), robot_, map);
    session.entry.previous = previous;
    session.entry.T_map_robot = T_map_robot;
    EXPECT_OK(sessions_.Create(Soon(), session, ""));
    for (const std::string& content : driven.contents) {
      const TestBlob blob(content);
      EXPECT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
    }
    for (std::size_t i = 0; i < driven.log.size(); i += 500) {
      const std::size_t end = std::min(i + 500, driven.log.size());
      EXPECT_OK(Append(session.id, {driven.log.begin() + static_cast<std::ptrdiff_t>(i),
                                    driven.log.begin() + static_cast<std::ptrdiff_t>(end)}));
    }
    EXPECT_OK(sessions_.Finish(Soon(), site_, session.id, static_cast<std::int64_t>(driven.log.size())));
    return session.id;
  }

  std::vector<SessionId> SendAll(const std::vector<DrivenSession>& drive) {
    std::vector<SessionId> sessions;
    for (const DrivenSession& driven : drive) {
      sessions.push_back(sessions.empty() ? Send(driven, map_, {}) : Send(driven, {}, sessions.back()));
    }
    return sessions;
  }

  void AwaitMapped(const std::vector<SessionId>& sessions) {
    for (const SessionId& session : sessions) {
      for (int i = 0;
           i < 3000 * kSlowdown && sessions_.Get(Soon(), site_, session)->state != storage::SessionState::kMapped;
           ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
      ASSERT_EQ(sessions_.Get(Soon(), site_, session)->state, storage::SessionState::kMapped) << session.value();
    }
    while (Value("SELECT count(*) FROM sessions WHERE door_reports > 0 AND NOT doors_judged") != "0") {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  std::vector<SessionId> MapAll(const std::vector<DrivenSession>& drive) {
    std::vector<SessionId> sessions = SendAll(drive);
    AwaitMapped(sessions);
    return sessions;
  }

  std::vector<closure::DoorVerdict> Verdicts(const SessionId& session) {
    const auto verdicts = verdicts_.List(Soon(), site_, session, 0, 100);
    EXPECT_OK(verdicts);
    return *verdicts;
  }
  // As text; prints the reasons.
  std::vector<std::string> Decisions(const std::vector<SessionId>& sessions) {
    std::vector<std::string> decisions;
    for (const SessionId& session : sessions) {
      for (const closure::DoorVerdict& verdict : Verdicts(session)) {
        decisions.emplace_back(closure::NameOf(verdict.decision));
        std::cout << session.value() << ": " << decisions.back() << ": " << verdict.reason << "\n";
        for (const closure::DoorComparison& compared : verdict.comparisons)
          std::cout << "    " << compared.reason << "\n";
      }
    }
    return decisions;
  }
  MapId MapOf(const SessionId& session) { return sessions_.Get(Soon(), site_, session)->map.value_or(MapId()); }

  static std::vector<std::string> DoorsOf(const std::vector<DrivenSession>& drive) {
    std::vector<std::string> doors;
    for (const DrivenSession& session : drive) doors.insert(doors.end(), session.doors.begin(), session.doors.end());
    return doors;
  }
  static DoorDriveOptions InTwoRooms() {
    DoorDriveOptions options = WithImagesAndClouds();
    options.campus = TwoRooms();
    options.robot = "r";
    return options;
  }
  // Driven once for all tests.
  static const std::vector<DrivenSession>& DriveInTwoRooms() {
    static const std::vector<DrivenSession> drive = DriveThroughDoors(InTwoRooms());
    return drive;
  }
  // Replaces the content of each image and cloud of the session by what `change` returns.
  static void Change(DrivenSession& session,
                     const std::function<std::string(const sensor::Record&, std::string)>& change) {
    std::size_t next = 0;  // contents are in the order of the log
    for (sensor::Record& record : session.log) {
      sensor::BlobRef* content = nullptr;
      if (auto* image = std::get_if<sensor::Image>(&record.payload)) content = &image->content;
      if (auto* cloud = std::get_if<sensor::PointCloud>(&record.payload)) content = &cloud->content;
      if (content == nullptr) continue;
      std::string& bytes = session.contents[next++];
      bytes = change(record, std::move(bytes));
      *content = {Sha256(bytes), static_cast<std::int64_t>(bytes.size())};
    }
    ASSERT_GT(next, 10U);
  }

  std::string Value(const std::string& sql) { return database_.SqlValue(sql); }

  closure::DoorClosureOptions options_;
  const storage::DoorVerdictStore verdicts_{*pool_};
  std::unique_ptr<Workers> workers_;
  int sessions_made_ = 0;
};

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "client/robot/news.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "client/sdk/uplink/uplink.h"
#include "core/base/mutex.h"
#include "enfilade/v1/door.pb.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "proto/convert/names.h"

namespace enfilade::robot {

struct UploaderOptions {
  client::UplinkOptions uplink;
  double follow_s = 1.0;     // between two looks at what the server has made of finished sessions
  bool global_pose = false;  // asks for the robot's pose in the world then, too
};

// Brings a robot's sessions to the server one after the other in the order in which they were begun, each while it is
// recorded, and then follows what becomes of them: mapped, doors judged, maps entered. What the server has for good
// leaves the spool, unless refused records are kept in it. Thread-safe.
class Uploader {
 public:
  struct Progress {
    std::string session;  // on its way; empty: none
    client::UplinkProgress uplink;
    std::int64_t waiting = 0;   // sessions in the spool that the server does not have whole
    std::int64_t followed = 0;  // sessions that it has, and is not through with
    std::string blocked;        // why nothing more can be brought over; empty: all is well
    std::string map;            // where the robot is, as far as the server has told: the map's name for people
    std::string map_name;       // and its resource name
  };

  // `spool` must outlive the uploader. All sessions in it are of one robot and site.
  Uploader(const client::Connection& connection, client::Spool& spool, convert::RobotName robot, NewsListener listener,
           const UploaderOptions& options);
  ~Uploader();
  Uploader(const Uploader&) = delete;
  Uploader& operator=(const Uploader&) = delete;

  void Start();
  void Stop();

  // `reports` door reports are in that session's log: so many verdicts are to come.
  void Expect(const SessionId& session, int reports);
  // Of the session that is on its way; elsewhere it has no effect.
  void ReportPose(const std::string& map, const PoseWithCovariance& T_map_robot, TimeNs time);

  Progress progress();
  // The server has every finished session; `judged`: it has mapped them and judged their doors, too.
  bool Done(bool judged);

 private:
  struct Followed {
    SessionId session;
    int verdicts = 0;  // that were told
    bool mapped = false;
    bool told_map = false;
  };

  void Run();
  void StartNext();
  void Look();  // at the uplink's progress
  void Ended(const absl::Status& status);
  void Follow();
  bool FollowOne(Followed& followed);  // true when there is nothing more to come
  void TellGlobalPose();
  void TellMap(const SessionId& session, const v1::MapEntered& entered);
  void TellVerdict(const SessionId& session, const v1::DoorVerdict& verdict);
  std::string DisplayNameOf(const std::string& map);
  int ExpectedOf(const SessionId& session);

  const client::Connection connection_;
  client::Spool& spool_;
  const convert::RobotName robot_;
  const NewsListener listener_;
  const UploaderOptions options_;
  std::thread worker_;

  // The worker's.
  std::deque<Followed> followed_;
  std::map<std::string, std::string> map_names_;
  std::string last_error_;
  std::string last_pose_error_;
  std::string last_global_pose_;

  Mutex mutex_;
  CondVar changed_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<client::Uplink> uplink_ ABSL_GUARDED_BY(mutex_);
  SessionId session_ ABSL_GUARDED_BY(mutex_);
  Progress progress_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, int> expected_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::robot

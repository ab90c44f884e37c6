// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "client/robot/notification.h"
#include "client/robot/upload/session_follower.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "client/sdk/uplink/uplink.h"
#include "core/base/mutex.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "proto/convert/names.h"

namespace enfilade::robot {

struct UploaderOptions {
  client::UplinkOptions uplink;
  double follow_s = 1.0;  // between two polls of what the server has made of finished sessions
  // After the server has refused a session for good, until it is tried again: an operator may have mended the cause.
  double retry_blocked_s = 60.0;
  bool global_pose = false;  // polls the robot's pose in the world, too
};

// Uploads a robot's sessions one after the other in the order in which they began, each while it is still recorded, and
// then follows what the server makes of them (SessionFollower). A session that the server has received whole is removed
// from the spool, unless refused records are kept in it. One that the server refuses for good blocks the later ones; it
// is tried again from time to time. Thread-safe.
class Uploader {
 public:
  struct Progress {
    std::string session;  // being uploaded; empty: none
    client::UplinkProgress uplink;
    std::int64_t waiting = 0;   // sessions in the spool that the server has not received whole
    std::int64_t followed = 0;  // sessions that it has received and is still mapping or judging
    std::int64_t unmapped = 0;  // of these, not mapped yet
    bool reachable = true;      // whether the server takes records, or else answers
    std::string blocked;        // why nothing is uploaded at present; empty: all is well
    std::string map;            // the display name of the map where the server last saw the robot
    std::string map_name;       // and its resource name
  };

  // `spool` must outlive the uploader. All sessions in it are of one robot and site.
  Uploader(const client::Connection& connection, client::Spool& spool, convert::RobotName robot,
           NotificationListener listener, const UploaderOptions& options);
  ~Uploader();
  Uploader(const Uploader&) = delete;
  Uploader& operator=(const Uploader&) = delete;

  void Start();
  void Stop();

  // This session and those after it are not uploaded until Release.
  void Hold(const SessionId& session);
  void Release();

  // The session's log holds `count` door reports, so this many verdicts will come.
  void ExpectVerdicts(const SessionId& session, int count);
  // Sent with the session that is being uploaded; without one it is dropped.
  void ReportPose(const std::string& map, const PoseWithCovariance& T_map_robot, TimeNs time);

  Progress progress();
  // The server has every finished session; with `judged` it has also mapped them and judged their doors.
  bool Done(bool judged);
  // The server has every session before the held one, and has mapped them.
  bool EarlierMapped();

 private:
  void Run();
  void StartNext();
  void UpdateProgress();
  void Follow();
  void OnUplinkEnded(const absl::Status& status);
  // Called by the uplink's thread and the worker.
  void OnMapEntered(const SessionId& session, const v1::MapEntered& entered);
  int ExpectedVerdicts(const SessionId& session);

  const client::Connection connection_;
  client::Spool& spool_;
  const NotificationListener listener_;
  const UploaderOptions options_;
  std::thread worker_;

  // Used by the worker only.
  SessionFollower follower_;
  std::string last_error_;
  std::string last_pose_error_;
  std::chrono::steady_clock::time_point retry_blocked_;

  Mutex mutex_;
  CondVar changed_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<client::Uplink> uplink_ ABSL_GUARDED_BY(mutex_);
  SessionId session_ ABSL_GUARDED_BY(mutex_);
  Progress progress_ ABSL_GUARDED_BY(mutex_);
  std::optional<SessionId> held_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, int> expected_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::robot

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "client/sdk/uplink/record_stream.h"
#include "core/base/mutex.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::client {

struct UplinkOptions {
  RecordStreamOptions stream;
  double min_backoff_s = 0.2;
  double max_backoff_s = 30.0;
  // A robot or a map that the server does not know yet is created.
  bool create_missing = true;
  // Called from a thread of the uplink's, again on every connection: which map the session is mapped into.
  std::function<void(const v1::MapEntered&)> on_map_entered;
};

struct UplinkProgress {
  bool connected = false;  // a stream is open
  std::int64_t acknowledged_sequence = 0;
  std::int64_t sent_sequence = 0;  // on the present stream
  std::int64_t connections = 0;    // streams opened so far
  std::int64_t quarantined = 0;
  std::int64_t poses_refused = 0;
  std::string pose_error;  // why the server refused the last of them
  std::string last_error;  // why the last try failed; empty while all is well
};

// Brings one session of a spool to the server: creates it there, streams what is recorded while it is recorded, and
// finishes it when the spool's session is finished and all of it acknowledged.
//
// Connections that break, a server that is away, drains or has a full disk are tried again for ever, with back-off and
// jitter, from the server's highest acknowledged sequence on. A record that the server refuses is put into quarantine
// and a Withheld record sent in its place. Everything else the server says no to (session deleted, ids taken, not
// permitted) ends the uplink with that status; the spool keeps what is not acknowledged.
//
// Thread-safe.
class Uplink {
 public:
  // `spool` must outlive the uplink and hold the session.
  Uplink(const Connection& connection, client::Spool& spool, SessionId session, const UplinkOptions& options = {});
  // Stops.
  ~Uplink();
  Uplink(const Uplink&) = delete;
  Uplink& operator=(const Uplink&) = delete;

  // Call once.
  void Start();
  // CANCELLED is then what Wait gives, unless the end came first. May be repeated.
  void Stop();

  // How it ended: OK when the server knows the session as finished with all its records; nullopt when that is not so
  // after `timeout`.
  std::optional<absl::Status> WaitFor(std::chrono::steady_clock::duration timeout);

  UplinkProgress progress();

  // Reports where the robot is now, by a localisation of its own: sent when a stream is open, not kept on disk, and the
  // newest takes the place of one that is not sent yet. `map`: sites/{site}/maps/{map}.
  void ReportPose(const std::string& map, const PoseWithCovariance& T_map_robot, TimeNs time);

 private:
  void Run();
  // One try. kComplete: the session is closed.
  RecordStream::Outcome RunOnce();
  RecordStream::Outcome Close();
  // False when stopped meanwhile.
  bool Sleep(double seconds);
  RecordStream::Listener MakeListener();

  const Connection connection_;
  client::Spool& spool_;
  const SessionId id_;
  const UplinkOptions options_;
  std::thread worker_;
  bool session_known_ = false;  // the worker's: by the server

  Mutex mutex_;
  CondVar changed_;
  UplinkProgress progress_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  RecordStream* stream_ ABSL_GUARDED_BY(mutex_) = nullptr;  // while one is running
  std::optional<absl::Status> result_ ABSL_GUARDED_BY(mutex_);
  std::optional<v1::PoseReport> pose_report_ ABSL_GUARDED_BY(mutex_);  // not sent yet
};

}  // namespace enfilade::client

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
  // Creates the robot or the map if the server does not have it.
  bool create_missing = true;
  // Called from a thread of the uplink, on every connection: the map that the session is mapped into.
  std::function<void(const v1::MapEntered&)> on_map_entered;
};

struct UplinkProgress {
  bool connected = false;  // a stream is open
  std::int64_t acknowledged_sequence = 0;
  std::int64_t sent_sequence = 0;  // on the current stream
  std::int64_t connections = 0;    // streams opened so far
  std::int64_t quarantined = 0;
  std::int64_t poses_refused = 0;
  std::string pose_error;  // why the server refused the last one
  std::string last_error;  // why the last attempt failed; empty after a success
};

// Uploads one session of a spool: creates it on the server, streams records while they are recorded, and finishes it
// when the spool's session is finished and all of its records are acknowledged.
//
// If the connection breaks, or the server is away, draining, or out of disk, it tries again without limit, with
// back-off and jitter, from the server's highest acknowledged sequence. A record that the server refuses goes into
// quarantine, and a Withheld record is sent instead. Any other refusal (session deleted, ids taken, no permission) ends
// the uplink with that status; the spool keeps what is not acknowledged.
//
// Thread-safe.
class Uplink {
 public:
  // `spool` must outlive the uplink and hold the session.
  Uplink(const Connection& connection, Spool& spool, SessionId session, const UplinkOptions& options = {});
  // Stops.
  ~Uplink();
  Uplink(const Uplink&) = delete;
  Uplink& operator=(const Uplink&) = delete;

  // Call once.
  void Start();
  // WaitFor then returns CANCELLED, unless the uplink had ended before. May be repeated.
  void Stop();

  // How it ended; nullopt if it is still running after `timeout`. OK: the session is finished on the server, with all
  // of its records.
  std::optional<absl::Status> WaitFor(std::chrono::steady_clock::duration timeout);

  UplinkProgress progress();

  // Reports the robot's present pose, by its own localisation. Sent when a stream is open and not kept on disk; a newer
  // pose replaces one that is not sent yet. `map`: sites/{site}/maps/{map}.
  void ReportPose(const std::string& map, const PoseWithCovariance& T_map_robot, TimeNs time);

 private:
  void Run();
  // One attempt. kComplete: the session is closed.
  RecordStream::Outcome RunOnce();
  RecordStream::Outcome Close();
  // False if stopped meanwhile.
  bool Sleep(double seconds);
  RecordStream::Listener MakeListener();

  const Connection connection_;
  Spool& spool_;
  const SessionId id_;
  const UplinkOptions options_;
  std::thread worker_;
  bool session_known_ = false;  // the server has it; used by the worker only

  Mutex mutex_;
  CondVar changed_;
  UplinkProgress progress_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  RecordStream* stream_ ABSL_GUARDED_BY(mutex_) = nullptr;  // while one is running
  std::optional<absl::Status> result_ ABSL_GUARDED_BY(mutex_);
  std::optional<v1::PoseReport> pose_report_ ABSL_GUARDED_BY(mutex_);  // not sent yet
};

}  // namespace enfilade::client

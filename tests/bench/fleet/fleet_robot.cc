// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/fleet/fleet_robot.h"

#include <algorithm>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "client/sdk/uplink/session_setup.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "google/protobuf/util/time_util.h"

namespace enfilade::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kStartSigma = 0.02;     // m
constexpr double kStartYawSigma = 0.01;  // rad

class FleetRobot {
 public:
  FleetRobot(const client::Connection& connection, const RecordedDrive& drive, const FleetRobotOptions& options,
             const FleetClock& clock)
      : connection_(connection), drive_(drive), options_(options), clock_(clock) {}

  FleetRobotResult Run() {
    Clock::time_point begin = clock_.start + Seconds(options_.start_s);
    while (result_.status.ok() && begin < clock_.end) {
      result_.status = DriveOnce(begin);
      begin = std::max(Clock::now(), begin + Seconds(drive_.seconds));
      first_drive_ = false;
    }
    return std::move(result_);
  }

 private:
  static Clock::duration Seconds(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

  absl::Status DriveOnce(Clock::time_point begin) {
    std::map<SessionId, SessionId> ids;  // recorded, and of this drive
    for (const RecordedSession& recorded : drive_.sessions) {
      if (recorded.batches.empty()) continue;
      const Clock::time_point due = begin + Seconds(recorded.batches.front().due);
      if (due >= clock_.end) return absl::OkStatus();
      std::this_thread::sleep_until(due);
      client::SpoolSession session = recorded.session;
      session.site = options_.site;
      session.robot = options_.robot;
      session.id = SessionId(NewUuid());
      session.request_id = NewUuid();
      ids.emplace(recorded.session.id, session.id);
      if (session.entry.previous) session.entry.previous = ids.at(*session.entry.previous);
      if (!session.entry.previous && !(options_.first_of_site && first_drive_)) EnterStart(session);
      ENFILADE_ASSIGN_OR_RETURN(const v1::Session created, client::EnsureSession(connection_, session, true));
      map_ = created.map();
      ENFILADE_RETURN_IF_ERROR(Stream(created.name(), recorded, begin));
      session.last_sequence = sent_;
      ENFILADE_RETURN_IF_ERROR(client::FinishSession(connection_, session).status());
      ++result_.sessions;
    }
    return absl::OkStatus();
  }

  // All drives of a building start at the same place: the origin of the first map.
  static void EnterStart(client::SpoolSession& session) {
    PoseWithCovariance start;
    start.covariance.diagonal() << kStartSigma * kStartSigma, kStartSigma * kStartSigma,
        kStartYawSigma * kStartYawSigma;
    session.entry.T_map_robot = start;
  }

  absl::Status Stream(const std::string& session, const RecordedSession& recorded, Clock::time_point begin) {
    const std::unique_ptr<v1::IngestService::Stub> stub = v1::IngestService::NewStub(connection_.channel());
    grpc::ClientContext context;
    const auto stream = stub->StreamRecords(&context);
    v1::StreamRecordsRequest open;
    open.mutable_open()->set_session(session);
    bool ok = stream->Write(open);
    sent_ = 0;
    for (const DueBatch& batch : recorded.batches) {
      const Clock::time_point due = begin + Seconds(batch.due);
      if (!ok || due >= clock_.end) break;
      std::this_thread::sleep_until(due);
      ok = stream->Write(batch.request) && AwaitAcknowledgement(*stream, batch.last_sequence);
      if (!ok) break;
      Count(batch, due);
      ok = ReportPose(*stream);
    }
    stream->WritesDone();
    v1::StreamRecordsResponse ignored;
    while (stream->Read(&ignored)) {
    }
    return client::FromGrpcStatus(stream->Finish());
  }

  template <typename StreamT>
  bool AwaitAcknowledgement(StreamT& stream, std::int64_t sequence) {
    v1::StreamRecordsResponse response;
    while (stream.Read(&response)) {
      if (response.has_map_entered()) map_ = response.map_entered().map();
      if (response.has_refused()) return false;
      if (response.has_acknowledgement() && response.acknowledgement().acknowledged_sequence() >= sequence) return true;
    }
    return false;
  }

  void Count(const DueBatch& batch, Clock::time_point due) {
    const Clock::time_point now = Clock::now();
    sent_ = batch.last_sequence;
    result_.acknowledged.push_back({std::chrono::duration<double>(now - clock_.start).count(),
                                    std::chrono::duration<double, std::milli>(now - due).count()});
    result_.records += batch.request.batch().records_size();
    for (const v1::Record& record : batch.request.batch().records()) result_.scans += record.has_laser_scan() ? 1 : 0;
  }

  template <typename StreamT>
  bool ReportPose(StreamT& stream) {
    const Clock::time_point now = Clock::now();
    if (map_.empty() || options_.pose_reports_hz <= 0.0 || now < next_report_) return true;
    next_report_ = std::max(now, next_report_ + Seconds(1.0 / options_.pose_reports_hz));
    v1::StreamRecordsRequest request;
    v1::PoseReport& report = *request.mutable_pose_report();
    report.set_map(map_);
    report.mutable_pose_map_robot()->mutable_pose()->set_x(0.1 * (static_cast<double>(result_.pose_reports % 10)));
    for (int i = 0; i < 9; ++i) report.mutable_pose_map_robot()->add_covariance(i % 4 == 0 ? 0.01 : 0.0);
    *report.mutable_time() = google::protobuf::util::TimeUtil::GetCurrentTime();
    ++result_.pose_reports;
    return stream.Write(request);
  }

  const client::Connection& connection_;
  const RecordedDrive& drive_;
  const FleetRobotOptions& options_;
  const FleetClock& clock_;
  bool first_drive_ = true;
  std::int64_t sent_ = 0;  // of the session, acknowledged
  std::string map_;        // that the robot is in; empty until a verdict says
  Clock::time_point next_report_;
  FleetRobotResult result_;
};

}  // namespace

FleetRobotResult DriveUntilEnd(const client::Connection& connection, const RecordedDrive& drive,
                               const FleetRobotOptions& options, const FleetClock& clock) {
  return FleetRobot(connection, drive, options, clock).Run();
}

}  // namespace enfilade::bench

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/fleet/recorded_drive.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "client/robot/agent/agent.h"
#include "client/robot/upload/uploader.h"
#include "client/simulator/campus/random_building.h"
#include "client/simulator/simulation.h"
#include "client/simulator/world/world.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "proto/convert/record.h"

namespace enfilade::bench {
namespace {

constexpr char kStartMap[] = "Start";
constexpr std::int64_t kPageRecords = 1000;
constexpr std::int64_t kPageBytes = 8 << 20;

// Runs the agent without a server: it writes into the spool only.
absl::Status RecordWithAgent(simulator::RobotSimulation& drive, client::Spool& spool) {
  const client::Connection nowhere("unix:/nonexistent", std::chrono::seconds(1));
  const SiteId site("site");
  const RobotId robot("robot");
  const auto ignore = [](const robot::Notification&) {};
  robot::Uploader uploader(nowhere, spool, {site, robot}, ignore, {});
  ENFILADE_ASSIGN_OR_RETURN(
      const std::unique_ptr<robot::Agent> agent,
      robot::Agent::Make(
          {.site = site, .robot = robot, .source = "fleet", .options = {}, .start = robot::RecordNewMap{kStartMap}},
          {.connection = nowhere, .spool = spool, .uploader = uploader, .listener = ignore, .interrupted = [] {
             return false;
           }}));
  ENFILADE_RETURN_IF_ERROR(agent->Start());
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<simulator::SimulatedRecord> record, drive.Next());
    if (!record) break;
    ENFILADE_RETURN_IF_ERROR(agent->Add({std::move(record->payload), std::move(record->content)}));
  }
  return agent->Finish();
}

absl::StatusOr<RecordedSession> ReadSession(client::Spool& spool, const client::SpoolSession& session, TimeNs start,
                                            double batch_s) {
  RecordedSession recorded{session, {}};
  for (std::int64_t after = 0; after < session.last_sequence;) {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<sensor::Record> page,
                              spool.ReadBatch(session.id, after, kPageRecords, kPageBytes));
    for (const sensor::Record& record : page) {
      const double time = ToSeconds(sensor::TimeOf(record.payload) - start);
      if (recorded.batches.empty() || time > recorded.batches.back().due) {
        recorded.batches.push_back({time + batch_s, {}, 0});
      }
      DueBatch& batch = recorded.batches.back();
      *batch.request.mutable_batch()->add_records() = convert::ToProto(record);
      batch.last_sequence = record.sequence;
    }
    after = page.back().sequence;
  }
  return recorded;
}

}  // namespace

absl::StatusOr<RecordedDrive> RecordDrive(std::uint64_t building, std::uint64_t noise_seed, double batch_s,
                                          const std::filesystem::path& folder) {
  const auto world = std::make_shared<const simulator::World>(simulator::RandomBuilding(building));
  simulator::SimulationOptions options;
  options.seed = noise_seed;
  options.scan_hz = 5.0;
  options.odometry_hz = 20.0;
  ENFILADE_ASSIGN_OR_RETURN(simulator::RobotSimulation drive,
                            simulator::RobotSimulation::Start(world, "robot", options));
  std::filesystem::create_directories(folder);
  ENFILADE_ASSIGN_OR_RETURN(
      const std::unique_ptr<client::Spool> spool,
      client::Spool::Open(folder / fmt::format("{}-{}.spool", building, noise_seed), {.check_on_open = false}));
  ENFILADE_RETURN_IF_ERROR(RecordWithAgent(drive, *spool));
  RecordedDrive recorded;
  for (const client::SpoolSession& session : spool->ListSessions()) {
    ENFILADE_ASSIGN_OR_RETURN(RecordedSession read, ReadSession(*spool, session, options.start_time, batch_s));
    if (!read.batches.empty()) recorded.seconds = std::max(recorded.seconds, read.batches.back().due);
    recorded.sessions.push_back(std::move(read));
  }
  recorded.scans = static_cast<std::int64_t>(drive.truth().poses.size());
  return recorded;
}

}  // namespace enfilade::bench

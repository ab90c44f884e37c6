// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/spool/spool.h"
#include "enfilade/v1/ingest_service.pb.h"

namespace enfilade::bench {

// What a robot has sent by one moment of its drive.
struct DueBatch {
  double due = 0.0;  // s since the drive's start
  v1::StreamRecordsRequest request;
  std::int64_t last_sequence = 0;
};

// As the robot's agent spooled it. Ids, site and robot stand for others.
struct RecordedSession {
  client::SpoolSession session;
  std::vector<DueBatch> batches;
};

// A drive through a random building, in sessions from door to door, with door reports.
struct RecordedDrive {
  std::vector<RecordedSession> sessions;
  double seconds = 0.0;
  std::int64_t scans = 0;
};

// Simulates the drive with scans (5 Hz) and odometry (20 Hz) and lets an agent record it, in `folder`. A batch holds
// what is measured in `batch_s`.
absl::StatusOr<RecordedDrive> RecordDrive(std::uint64_t building, std::uint64_t noise_seed, double batch_s,
                                          const std::filesystem::path& folder);

}  // namespace enfilade::bench

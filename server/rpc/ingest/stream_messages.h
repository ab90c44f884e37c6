// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "server/app/ingest/ingest.h"
#include "storage/graph/robot_pose_store.h"

namespace enfilade::server {

// Values of StreamRecords as its messages, and the other way round.

v1::StreamRecordsResponse ToResponse(const Refusal& refusal);

// All but robot and session. INVALID_ARGUMENT naming the field.
absl::StatusOr<storage::RobotPose> ReadPoseReport(const v1::PoseReport& report);

}  // namespace enfilade::server

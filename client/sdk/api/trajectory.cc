// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/trajectory.h"

#include "core/base/status_macros.h"
#include "enfilade/v1/session_service.grpc.pb.h"

namespace enfilade::client {

absl::StatusOr<std::int64_t> ExportTrajectory(const Connection& connection, const std::string& session,
                                              const std::function<absl::Status(const v1::TrajectoryPose&)>& take) {
  v1::ExportTrajectoryRequest request;
  request.set_name(session);
  v1::SessionService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  const auto reader = stub.ExportTrajectory(&context, request);
  v1::ExportTrajectoryResponse part;
  std::int64_t poses = 0;
  absl::Status status;
  while (status.ok() && reader->Read(&part)) {
    for (const v1::TrajectoryPose& pose : part.poses()) {
      status = take(pose);
      if (!status.ok()) break;
      ++poses;
    }
  }
  if (!status.ok()) context.TryCancel();
  const absl::Status ended = FromGrpcStatus(reader->Finish(), connection.address());
  ENFILADE_RETURN_IF_ERROR(status);
  ENFILADE_RETURN_IF_ERROR(ended);
  return poses;
}

}  // namespace enfilade::client

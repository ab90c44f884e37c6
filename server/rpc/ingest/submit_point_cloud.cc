// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "server/rpc/ingest/handlers.h"
#include "server/rpc/ingest/submit.h"

namespace enfilade::server {

absl::StatusOr<v1::SubmitPointCloudResponse> SubmitPointCloud(const Services& services, const Call& call,
                                                              const v1::SubmitPointCloudRequest& request) {
  v1::SubmitPointCloudResponse response;
  v1::Record record;
  record.set_sequence(request.sequence());
  if (request.has_point_cloud()) {
    *record.mutable_point_cloud() = request.point_cloud();
    CompleteContent(request.data(), *record.mutable_point_cloud()->mutable_content());
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t acknowledged,
                            SubmitRecord(services, call, request.session(), record, &request.data()));
  response.set_acknowledged_sequence(acknowledged);
  return response;
}

}  // namespace enfilade::server

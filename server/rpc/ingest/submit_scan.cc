// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "server/rpc/ingest/handlers.h"
#include "server/rpc/ingest/submit.h"

namespace enfilade::server {

absl::StatusOr<v1::SubmitScanResponse> SubmitScan(const Services& services, const Call& call,
                                                  const v1::SubmitScanRequest& request) {
  v1::SubmitScanResponse response;
  v1::Record record;
  record.set_sequence(request.sequence());
  if (request.has_laser_scan()) *record.mutable_laser_scan() = request.laser_scan();
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t acknowledged, SubmitRecord(services, call, request.session(), record));
  response.set_acknowledged_sequence(acknowledged);
  return response;
}

}  // namespace enfilade::server

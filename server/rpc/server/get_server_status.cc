// SPDX-License-Identifier: Apache-2.0
#include "core/base/version.h"
#include "server/rpc/server/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::GetServerStatusResponse> GetServerStatus(const Services& services, const Call& /*call*/,
                                                            const v1::GetServerStatusRequest& /*request*/) {
  v1::GetServerStatusResponse response;
  const Readiness::State state = services.readiness.state();
  response.set_version(kVersion);
  response.mutable_uptime()->set_seconds(
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - services.start_time).count());
  response.set_ready(state.ready);
  response.set_not_ready_reason(state.reason);
  response.set_schema_version(state.schema.deployed);
  response.set_expected_schema_version(state.schema.expected);
  response.set_sessions_mapping(services.metrics.sessions_mapping());
  response.set_streams_open(services.metrics.streams_open());
  response.set_surveys_sites(services.options.survey.share > 0.0);
  for (std::string& warning : services.options.Warnings()) *response.add_warnings() = std::move(warning);
  return response;
}

}  // namespace enfilade::server

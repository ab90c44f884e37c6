// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/map_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of MapService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::CreateMapResponse> CreateMap(const Services& services, const Call& call,
                                                const v1::CreateMapRequest& request);
absl::StatusOr<v1::GetMapResponse> GetMap(const Services& services, const Call& call, const v1::GetMapRequest& request);
absl::StatusOr<v1::ListMapsResponse> ListMaps(const Services& services, const Call& call,
                                              const v1::ListMapsRequest& request);
absl::StatusOr<v1::UpdateMapResponse> UpdateMap(const Services& services, const Call& call,
                                                const v1::UpdateMapRequest& request);
absl::StatusOr<v1::DeleteMapResponse> DeleteMap(const Services& services, const Call& call,
                                                const v1::DeleteMapRequest& request);
absl::StatusOr<v1::GetMapRevisionResponse> GetMapRevision(const Services& services, const Call& call,
                                                          const v1::GetMapRevisionRequest& request);
absl::StatusOr<v1::TagMapRevisionResponse> TagMapRevision(const Services& services, const Call& call,
                                                          const v1::TagMapRevisionRequest& request);
absl::StatusOr<v1::ListMapRevisionsResponse> ListMapRevisions(const Services& services, const Call& call,
                                                              const v1::ListMapRevisionsRequest& request);
absl::StatusOr<v1::SetMapAliasResponse> SetMapAlias(const Services& services, const Call& call,
                                                    const v1::SetMapAliasRequest& request);
absl::StatusOr<v1::RollBackMapAliasResponse> RollBackMapAlias(const Services& services, const Call& call,
                                                              const v1::RollBackMapAliasRequest& request);
absl::StatusOr<v1::ListMapAliasesResponse> ListMapAliases(const Services& services, const Call& call,
                                                          const v1::ListMapAliasesRequest& request);
absl::StatusOr<v1::DeleteMapAliasResponse> DeleteMapAlias(const Services& services, const Call& call,
                                                          const v1::DeleteMapAliasRequest& request);
absl::StatusOr<v1::RestoreMapRevisionResponse> RestoreMapRevision(const Services& services, const Call& call,
                                                                  const v1::RestoreMapRevisionRequest& request);
absl::StatusOr<v1::DiffMapRevisionsResponse> DiffMapRevisions(const Services& services, const Call& call,
                                                              const v1::DiffMapRevisionsRequest& request);

}  // namespace enfilade::server

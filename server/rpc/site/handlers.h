// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/site_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of SiteService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::CreateSiteResponse> CreateSite(const Services& services, const Call& call,
                                                  const v1::CreateSiteRequest& request);
absl::StatusOr<v1::GetSiteResponse> GetSite(const Services& services, const Call& call,
                                            const v1::GetSiteRequest& request);
absl::StatusOr<v1::ListSitesResponse> ListSites(const Services& services, const Call& call,
                                                const v1::ListSitesRequest& request);
absl::StatusOr<v1::UpdateSiteResponse> UpdateSite(const Services& services, const Call& call,
                                                  const v1::UpdateSiteRequest& request);
absl::StatusOr<v1::DeleteSiteResponse> DeleteSite(const Services& services, const Call& call,
                                                  const v1::DeleteSiteRequest& request);

absl::StatusOr<v1::ListAuditEntriesResponse> ListAuditEntries(const Services& services, const Call& call,
                                                              const v1::ListAuditEntriesRequest& request);

}  // namespace enfilade::server

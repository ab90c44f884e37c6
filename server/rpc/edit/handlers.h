// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "enfilade/v1/map_edit_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"
#include "server/rpc/call/watch_stream.h"

namespace enfilade::server {

// MapEditService.

absl::StatusOr<v1::CreateMapDraftResponse> CreateMapDraft(const Services& services, const Call& call,
                                                          const v1::CreateMapDraftRequest& request);
absl::StatusOr<v1::GetMapDraftResponse> GetMapDraft(const Services& services, const Call& call,
                                                    const v1::GetMapDraftRequest& request);
absl::StatusOr<v1::ListMapDraftsResponse> ListMapDrafts(const Services& services, const Call& call,
                                                        const v1::ListMapDraftsRequest& request);
absl::StatusOr<v1::DeleteMapDraftResponse> DeleteMapDraft(const Services& services, const Call& call,
                                                          const v1::DeleteMapDraftRequest& request);
absl::StatusOr<v1::AppendMapEditsResponse> AppendMapEdits(const Services& services, const Call& call,
                                                          const v1::AppendMapEditsRequest& request);
absl::StatusOr<v1::SetMapEditsActiveResponse> SetMapEditsActive(const Services& services, const Call& call,
                                                                const v1::SetMapEditsActiveRequest& request);
absl::StatusOr<v1::ListMapEditsResponse> ListMapEdits(const Services& services, const Call& call,
                                                      const v1::ListMapEditsRequest& request);
absl::StatusOr<v1::ReadMapDraftTilesResponse> ReadMapDraftTiles(const Services& services, const Call& call,
                                                                const v1::ReadMapDraftTilesRequest& request);
absl::StatusOr<v1::ReportMapDraftPresenceResponse> ReportMapDraftPresence(
    const Services& services, const Call& call, const v1::ReportMapDraftPresenceRequest& request);
absl::StatusOr<Watch<v1::WatchMapDraftResponse>> WatchMapDraft(const Services& services, const Call& call,
                                                               const v1::WatchMapDraftRequest& request);
absl::StatusOr<v1::CheckMapDraftResponse> CheckMapDraft(const Services& services, const Call& call,
                                                        const v1::CheckMapDraftRequest& request);
absl::StatusOr<v1::RebaseMapDraftResponse> RebaseMapDraft(const Services& services, const Call& call,
                                                          const v1::RebaseMapDraftRequest& request);
absl::StatusOr<v1::PublishMapDraftResponse> PublishMapDraft(const Services& services, const Call& call,
                                                            const v1::PublishMapDraftRequest& request);
absl::StatusOr<v1::ListContestedEditsResponse> ListContestedEdits(const Services& services, const Call& call,
                                                                  const v1::ListContestedEditsRequest& request);
absl::StatusOr<v1::SettleContestedEditsResponse> SettleContestedEdits(const Services& services, const Call& call,
                                                                      const v1::SettleContestedEditsRequest& request);

}  // namespace enfilade::server

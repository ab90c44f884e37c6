// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/session_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of SessionService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::CreateSessionResponse> CreateSession(const Services& services, const Call& call,
                                                        const v1::CreateSessionRequest& request);
absl::StatusOr<v1::GetSessionResponse> GetSession(const Services& services, const Call& call,
                                                  const v1::GetSessionRequest& request);
absl::StatusOr<v1::ListSessionsResponse> ListSessions(const Services& services, const Call& call,
                                                      const v1::ListSessionsRequest& request);
absl::StatusOr<v1::FinishSessionResponse> FinishSession(const Services& services, const Call& call,
                                                        const v1::FinishSessionRequest& request);
absl::StatusOr<v1::DeleteSessionResponse> DeleteSession(const Services& services, const Call& call,
                                                        const v1::DeleteSessionRequest& request);
absl::StatusOr<v1::ListClosuresResponse> ListClosures(const Services& services, const Call& call,
                                                      const v1::ListClosuresRequest& request);
absl::StatusOr<v1::SuspendClosureResponse> SuspendClosure(const Services& services, const Call& call,
                                                          const v1::SuspendClosureRequest& request);
absl::StatusOr<v1::ResumeClosureResponse> ResumeClosure(const Services& services, const Call& call,
                                                        const v1::ResumeClosureRequest& request);

absl::StatusOr<v1::ListDoorVerdictsResponse> ListDoorVerdicts(const Services& services, const Call& call,
                                                              const v1::ListDoorVerdictsRequest& request);
absl::StatusOr<v1::GetDoorImagesResponse> GetDoorImages(const Services& services, const Call& call,
                                                        const v1::GetDoorImagesRequest& request);

}  // namespace enfilade::server

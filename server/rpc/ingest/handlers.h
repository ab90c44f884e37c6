// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of IngestService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::SubmitScanResponse> SubmitScan(const Services& services, const Call& call,
                                                  const v1::SubmitScanRequest& request);
absl::StatusOr<v1::SubmitOdometryResponse> SubmitOdometry(const Services& services, const Call& call,
                                                          const v1::SubmitOdometryRequest& request);
absl::StatusOr<v1::SubmitImageResponse> SubmitImage(const Services& services, const Call& call,
                                                    const v1::SubmitImageRequest& request);
absl::StatusOr<v1::SubmitPointCloudResponse> SubmitPointCloud(const Services& services, const Call& call,
                                                              const v1::SubmitPointCloudRequest& request);

}  // namespace enfilade::server

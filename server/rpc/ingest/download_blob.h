// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/server_stream.h"

namespace enfilade::server {

// IngestService.DownloadBlob.
absl::StatusOr<MessageSource<v1::DownloadBlobResponse>> DownloadBlob(const Services& services, const Call& call,
                                                                     const v1::DownloadBlobRequest& request);

}  // namespace enfilade::server

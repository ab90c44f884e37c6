// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "enfilade/v1/record.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The body of all Submit RPCs: stores one record, with its blob's bytes if it has any, and returns the session's
// acknowledged sequence.
absl::StatusOr<std::int64_t> SubmitRecord(const Services& services, const Call& call, const std::string& session,
                                          const v1::Record& record, const std::string* blob = nullptr);

// Sets size and digest of `data` if the client has not.
void CompleteContent(const std::string& data, v1::BlobRef& content);

}  // namespace enfilade::server

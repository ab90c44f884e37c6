// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "proto/convert/names.h"
#include "server/app/services.h"
#include "storage/call_context.h"

namespace enfilade::server {

// The revision to which the name of a revision or of an alias leads. INVALID_ARGUMENT naming the field; NOT_FOUND if
// there is no such alias. Whether the revision exists is not looked at.
absl::StatusOr<convert::RevisionName> ResolveRevision(const Services& services, const storage::CallContext& context,
                                                      std::string_view field, const std::string& name);

// The same; the name of a map leads to its newest revision, 0.
absl::StatusOr<convert::RevisionName> ResolveMapOrRevision(const Services& services,
                                                           const storage::CallContext& context, std::string_view field,
                                                           const std::string& name);

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/graph_service.pb.h"
#include "enfilade/v1/link_point.pb.h"
#include "enfilade/v1/site_service.pb.h"

namespace enfilade::client {

// Changes of link points are taken back by the inverse change, which the audit trail tells: what was changed together
// (entries of one `time` and actor) is taken back together. It is a change like any other: sent by ChangeGraph,
// audited, and undone in the same way.

// The audit entry `id` of sites/{site}, and all that was changed with it, the first first. NOT_FOUND: there is none, or
// it has expired.
absl::StatusOr<std::vector<v1::AuditEntry>> ReadAuditedChange(const Connection& connection, const std::string& site,
                                                              const std::string& id);

// The changes that take `entries` back, given the link points as they are now, by name. Only the fields that were
// changed become what they were, and only if nobody has changed them since: FAILED_PRECONDITION naming the link point
// and the field. FAILED_PRECONDITION, too: `entries` change no link point, or only what cannot be taken back in this
// way (evidence; what the optimisation has switched off). What was deleted is made again under its name, without its
// evidence.
absl::StatusOr<std::vector<v1::GraphChange>> InverseOf(const std::vector<v1::AuditEntry>& entries,
                                                       const std::map<std::string, v1::LinkPoint>& present);

// Both, with the link points read in between: for ChangeGraph or PreviewGraph.
absl::StatusOr<std::vector<v1::GraphChange>> ReadInverse(const Connection& connection, const std::string& site,
                                                         const std::string& id);

}  // namespace enfilade::client

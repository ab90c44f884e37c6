// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "enfilade/v1/link_point.pb.h"
#include "enfilade/v1/site_service.pb.h"

namespace enfilade::client {

// A link point as rows of the audit trail tell of it: columns of link_points and of link_point_anchors.

// Which resource an entry tells of.
struct AuditedPart {
  std::string link_point;  // its name; empty: the entry is of something else
  std::string anchor_map;  // the map's name; empty: the link point itself, or its evidence
  bool evidence = false;
};
AuditedPart PartOf(const v1::AuditEntry& entry);

// The link point without its anchors; its etag is not read. DATA_LOSS: no row.
absl::StatusOr<v1::LinkPoint> LinkPointOfRow(const std::string& row);

struct AuditedAnchor {
  int ordinal = 0;
  v1::Anchor anchor;
};
absl::StatusOr<AuditedAnchor> AnchorOfRow(const std::string& row);

bool IsSame(const v1::Anchor& a, const v1::Anchor& b);

}  // namespace enfilade::client

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/graph/link_point_store.h"

namespace enfilade::storage {

enum class AnchorChange { kNone, kMoved, kAdded };
AnchorChange CompareAnchors(const std::vector<graph::Anchor>& before, const std::vector<graph::Anchor>& after);

// ALREADY_EXISTS if one of `others` makes `changed` redundant (graph::FindCommonPlace), naming the nearest. Suspended
// link points do not count: what replaces them stands beside them. A forced link point is never redundant. It keeps
// away others that get an anchor (kAdded), but those that already stand beside it may be changed.
absl::Status CheckNotRedundant(const StoredLinkPoint& changed, AnchorChange change,
                               const std::vector<StoredLinkPoint>& others);

// A stored link point after a change, except version, etag and times. `others` has at least the link points of the site
// that share two maps with the result. ALREADY_EXISTS as in LinkPointStore.
absl::StatusOr<StoredLinkPoint> ApplyUpdate(const StoredLinkPoint& stored, const StoredLinkPoint& update,
                                            const std::vector<StoredLinkPoint>& others);
absl::StatusOr<StoredLinkPoint> ApplyAnchor(const StoredLinkPoint& stored, const NewAnchor& added,
                                            const std::vector<StoredLinkPoint>& others);
absl::StatusOr<StoredLinkPoint> ApplySuspension(const StoredLinkPoint& stored, bool suspended,
                                                const std::vector<StoredLinkPoint>& others);

}  // namespace enfilade::storage

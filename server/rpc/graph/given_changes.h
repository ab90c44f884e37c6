// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "enfilade/v1/graph_service.pb.h"
#include "google/protobuf/repeated_ptr_field.h"
#include "storage/graph/link_point_store.h"

namespace enfilade::server {

// A link point as it is before the changes. NOT_FOUND.
using FindStored = std::function<absl::StatusOr<storage::StoredLinkPoint>(const LinkPointId&)>;

struct GivenChanges {
  std::vector<storage::LinkPointChange> changes;
  // The link points that are made without a name, by the ids that they get: the numbers of their changes, from 1.
  std::map<LinkPointId, int> unnamed;
};

// The changes of a request. INVALID_ARGUMENT naming the change: none or too many, a field that is wrong, an update or
// an etag of a link point that an earlier one changes already. NOT_FOUND: what is updated does not exist.
absl::StatusOr<GivenChanges> ParseChanges(const SiteId& site,
                                          const google::protobuf::RepeatedPtrField<v1::GraphChange>& changes,
                                          const FindStored& find);

}  // namespace enfilade::server

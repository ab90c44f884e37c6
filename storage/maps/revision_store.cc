// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/revision_store.h"

#include "core/base/error.h"
#include "core/base/resource_name.h"

namespace enfilade::storage {
namespace {

constexpr char kLayersChangedPayload[] = "enfilade/layers-changed";

}  // namespace

absl::Status LayersChanged(const SiteId& site, const MapId& map) {
  absl::Status status = Aborted("the layers of {} have changed since they were read", NameOf(site, map));
  status.SetPayload(kLayersChangedPayload, absl::Cord("1"));
  return status;
}

bool AreLayersChanged(const absl::Status& status) { return status.GetPayload(kLayersChangedPayload).has_value(); }

}  // namespace enfilade::storage

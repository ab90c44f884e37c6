// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/areas/map_area.h"
#include "enfilade/v1/map_area.pb.h"
#include "storage/maps/map_area_store.h"

namespace enfilade::server {

v1::MapArea ToProto(const storage::MapArea& area);

// INVALID_ARGUMENT naming the field. Its name, etag and output-only fields are not read.
absl::StatusOr<areas::MapArea> FromProto(const v1::MapArea& area);

}  // namespace enfilade::server

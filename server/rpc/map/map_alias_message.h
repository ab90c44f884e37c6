// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/map.pb.h"
#include "storage/maps/map_alias_store.h"

namespace enfilade::server {

v1::MapAlias ToProto(const storage::MapAlias& alias);

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/closure/door_verdict.h"
#include "enfilade/v1/door.pb.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "server/app/closure/map_entries.h"

namespace enfilade::server {

v1::DoorVerdict ToProto(const SiteId& site, const closure::DoorVerdict& verdict);
v1::MapEntered ToProto(const MapEntry& entry);

}  // namespace enfilade::server

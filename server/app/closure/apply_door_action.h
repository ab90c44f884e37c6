// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/closure/door_action.h"
#include "core/closure/door_verdict.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/judge_report.h"
#include "server/app/closure/judging_lease.h"

namespace enfilade::server {

// Carries out the action of a judged report, except WaitForMapping, in one transaction: maps, link points, evidence and
// the verdict, which is returned. Only under the lease and at the graph's version that the report was judged by:
// ABORTED otherwise. NOT_FOUND: the map or link point has been deleted meanwhile. ALREADY_EXISTS: the link point would
// be redundant (FindChangedLinkPoint). Errors else are the stores'.
absl::StatusOr<closure::DoorVerdict> ApplyDoorAction(const DoorClosureStores& stores, const JudgingLease& lease,
                                                     const JudgedReport& judged);

// A new map as the store makes it, with the next free name.
storage::NewMap ToNewMap(const closure::MapToStart& map, const closure::DoorClosureOptions& options);

}  // namespace enfilade::server

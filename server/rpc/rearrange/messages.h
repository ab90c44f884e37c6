// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/rearrangement.pb.h"
#include "storage/graph/rearrangement_store.h"

namespace enfilade::server {

v1::Rearrangement ToProto(const storage::StoredRearrangement& rearrangement);

}  // namespace enfilade::server

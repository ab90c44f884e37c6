// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/graph/door_verdict_store.h"
#include "storage/graph/link_point_store.h"
#include "storage/graph/site_lease_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/feature_store.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// The stores that judging doors reads and writes.
struct DoorClosureStores {
  const storage::SessionStore& sessions;
  const storage::RecordStore& records;
  const storage::MappingStore& mappings;
  const storage::BlobStore& blobs;
  const storage::FeatureStore& features;
  const storage::MapStore& maps;
  const storage::LinkPointStore& link_points;
  const storage::DoorVerdictStore& verdicts;
  const storage::SiteLeaseStore& leases;
};

}  // namespace enfilade::server

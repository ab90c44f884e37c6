// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/blob_store.h"
#include "storage/door_verdict_store.h"
#include "storage/feature_store.h"
#include "storage/link_point_store.h"
#include "storage/map_store.h"
#include "storage/mapping_store.h"
#include "storage/record_store.h"
#include "storage/session_store.h"
#include "storage/site_lease_store.h"

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

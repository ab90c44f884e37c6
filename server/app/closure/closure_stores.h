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

// What judging doors reads and writes.
struct ClosureStores {
  const SessionStore& sessions;
  const RecordStore& records;
  const MappingStore& mappings;
  const BlobStore& blobs;
  const FeatureStore& features;
  const MapStore& maps;
  const LinkPointStore& link_points;
  const DoorVerdictStore& verdicts;
  const SiteLeaseStore& leases;
};

}  // namespace enfilade::server

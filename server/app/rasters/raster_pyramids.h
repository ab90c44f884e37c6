// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "server/app/runtime/metrics.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/pyramid_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// The pyramids of maps' revisions, each made and stored when it is imported or when somebody first asks for it: robots
// that map make more revisions than anybody looks at. One call makes the pyramid of a revision; others wait for it.
// Thread-safe.
class RasterPyramids {
 public:
  RasterPyramids(const storage::RevisionStore& revisions, const storage::PyramidStore& pyramids,
                 const storage::BlobStore& blobs, Metrics& metrics)
      : revisions_(revisions), pyramids_(pyramids), blobs_(blobs), metrics_(metrics) {}

  // May take seconds. NOT_FOUND if the revision goes; DATA_LOSS if a tile is damaged.
  absl::StatusOr<storage::StoredPyramid> Get(const storage::CallContext& context, const storage::MapRevision& revision);

 private:
  using Key = std::tuple<SiteId, MapId, std::int64_t>;

  absl::Status AwaitTurn(const storage::CallContext& context, const Key& key);
  absl::StatusOr<storage::StoredPyramid> FindOrMake(const storage::CallContext& context,
                                                    const storage::MapRevision& revision) const;
  // With the bytes of its tiles that are not stored yet, by digest.
  absl::Status Store(const storage::CallContext& context, const storage::MapRevision& revision,
                     const storage::StoredPyramid& pyramid, const std::map<std::string, std::string>& made) const;

  const storage::RevisionStore& revisions_;
  const storage::PyramidStore& pyramids_;
  const storage::BlobStore& blobs_;
  Metrics& metrics_;
  Mutex mutex_;
  CondVar changed_;
  std::set<Key> being_made_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::server

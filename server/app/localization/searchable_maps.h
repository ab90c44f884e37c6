// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "core/localization/searchable_map.h"
#include "server/app/edits/edited_revision.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// The newest revisions of maps, without people's edits, ready to be searched: what was built last stays in memory, up
// to a limit. Content that is built is recognised by its SHA-256, so a new revision is built anew and a repeated one is
// not. Thread-safe.
class SearchableMaps {
 public:
  // `max_bytes`: of the maps kept. Those in use are kept by their users.
  SearchableMaps(const RasterStores& stores, std::size_t max_bytes) : stores_(stores), max_bytes_(max_bytes) {}

  // Errors as ReadEvidence's and OnMapLattice's.
  absl::StatusOr<std::shared_ptr<const localization::SearchableMap>> Get(const storage::CallContext& context,
                                                                         const storage::MapRevision& revision);

  // Bytes of the maps kept.
  std::size_t bytes() const;

 private:
  struct Entry {
    std::string site;
    std::string content_sha256;
    std::shared_ptr<const localization::SearchableMap> map;
    std::size_t bytes = 0;
  };

  std::shared_ptr<const localization::SearchableMap> Find(const storage::MapRevision& revision);
  void Keep(Entry entry);

  const RasterStores stores_;
  const std::size_t max_bytes_;
  mutable Mutex mutex_;
  std::list<Entry> entries_ ABSL_GUARDED_BY(mutex_);  // most recently used first
  std::size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enfilade::server

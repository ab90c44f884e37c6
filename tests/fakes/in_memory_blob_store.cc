// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "tests/fakes/in_memory_stores.h"

namespace enfilade::testing {

absl::Status InMemoryBlobStore::Put(const storage::CallContext& context, const SiteId& site,
                                    absl::Span<const storage::BlobView> blobs) const {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateBlobs(blobs));
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const rows, access.GetSite(site));
  for (const storage::BlobView& blob : blobs) rows->blobs[std::string(blob.sha256)] = blob.data;
  return absl::OkStatus();
}

absl::StatusOr<std::string> InMemoryBlobStore::Get(const storage::CallContext& context, const SiteId& site,
                                                   std::string_view sha256) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  if (const SiteRows* const rows = access.FindSite(site)) {
    const auto found = rows->blobs.find(sha256);
    if (found != rows->blobs.end()) return found->second;
  }
  return NotFound("blob {} of {} does not exist", ToHex(sha256), NameOf(site));
}

}  // namespace enfilade::testing

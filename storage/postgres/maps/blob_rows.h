// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "storage/blob_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// INVALID_ARGUMENT where a digest is not that of its data, or the size is out of range.
absl::Status ValidateBlobs(absl::Span<const BlobView> blobs);

// Stores validated blobs that are not stored yet, and renews the grace time of those that are. Queued only.
void QueueBlobs(Transaction& transaction, const SiteId& site, absl::Span<const BlobView> blobs);

}  // namespace enfilade::storage::postgres

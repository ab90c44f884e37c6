// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "storage/maps/revision_store.h"
#include "storage/postgres/driver/params.h"

namespace enfilade::storage::postgres {

// Tiles as columns of a statement. Views: `tiles` must outlive them.
struct TileColumns {
  explicit TileColumns(const std::vector<TileRef>& tiles) {
    for (const TileRef& tile : tiles) {
      rows.push_back(tile.key.row);
      columns.push_back(tile.key.column);
      digests.push_back(Bytes{tile.sha256});
    }
  }
  std::vector<std::int32_t> rows, columns;
  std::vector<Bytes> digests;
};

}  // namespace enfilade::storage::postgres

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/slam/mapper/session_chain.h"

namespace enfilade::server {

// A mapped drive whose grid, most of which is unknown, is compressed: about a thirtieth of its size.
class PackedDrive {
 public:
  PackedDrive() = default;
  explicit PackedDrive(slam::ChainedMap drive);

  absl::StatusOr<slam::ChainedMap> Unpack() const;
  std::size_t bytes() const;

 private:
  slam::ChainedMap rest_;  // without the grid's cells
  std::size_t cell_count_ = 0;
  std::string cells_;  // compressed
};

struct CachedDrive {
  std::string before;   // identifies the drives before it, which it was begun in
  std::string records;  // those that it contains (KeyOf); empty: a new one
  // Unset: a new one, nothing says where the drive is, or it is not expected to go on.
  std::optional<slam::SessionChain> chain;
  std::string chained;  // identifies the records in the chain: more than `records` after an error
  PackedDrive mapped;
};

// The drives that the last survey of a site has mapped: while robots drive, and while a survey's rearrangements are
// applied, the site is surveyed again and again from the same records and some new ones. Not thread-safe.
class DriveCache {
 public:
  // The drive `id` after `update` has mapped what is new of it.
  absl::StatusOr<slam::ChainedMap> Get(const std::string& id, const std::function<absl::Status(CachedDrive&)>& update);

  // Forgets the drives that were not asked for since the last call.
  void DropUnused();

  // Memory held, about.
  std::size_t bytes() const;

 private:
  struct Entry {
    CachedDrive drive;
    bool used = false;
  };
  std::map<std::string, Entry> drives_;
};

}  // namespace enfilade::server

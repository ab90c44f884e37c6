// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/app/survey/growing_drive.h"

namespace enfilade::server {

struct CachedDrive {
  std::string before;                   // the drives before it, which it was begun in
  std::string records;                  // those that it contains (KeyOf); empty: a new one
  std::optional<GrowingDrive> growing;  // unset: a new one, or nothing says where the drive is
  MappedDrive mapped;
};

// The drives that the last survey of a site has mapped: while robots drive, and while a survey's rearrangements are
// applied, the site is surveyed again and again from the same records and some new ones. Not thread-safe.
class DriveCache {
 public:
  // The drive `id` after `update` has mapped what is new of it. Valid until DropUnused.
  absl::StatusOr<const MappedDrive*> Get(const std::string& id,
                                         const std::function<absl::Status(CachedDrive&)>& update);

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

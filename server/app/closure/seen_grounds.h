// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <string>

#include "core/closure/scan_location.h"

namespace enfilade::server {

// What robots have seen of maps, as it was last searched: a verdict compares a robot's scans with those of many maps,
// and the next one, or the same one after a wait, with most of them again. Not thread-safe.
class SeenGrounds {
 public:
  // `max_bytes`: of memory; what was asked for longest ago goes first, and one always stays.
  explicit SeenGrounds(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  // `digest` names all that the ground was made from. Null: not kept.
  std::shared_ptr<const closure::SeenGround> Find(const std::string& digest);
  void Keep(const std::string& digest, std::shared_ptr<const closure::SeenGround> ground);

  std::size_t bytes() const { return bytes_; }

 private:
  struct Entry {
    std::string digest;
    std::shared_ptr<const closure::SeenGround> ground;
    std::size_t bytes = 0;
  };

  const std::size_t max_bytes_;
  std::size_t bytes_ = 0;
  std::list<Entry> entries_;  // asked for last first; some hundreds
};

}  // namespace enfilade::server

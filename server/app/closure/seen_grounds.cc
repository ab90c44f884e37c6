// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/seen_grounds.h"

#include <algorithm>
#include <utility>

namespace enfilade::server {

std::shared_ptr<const closure::SeenGround> SeenGrounds::Find(const std::string& digest) {
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.digest == digest; });
  if (found == entries_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found);
  return found->ground;
}

void SeenGrounds::Keep(const std::string& digest, std::shared_ptr<const closure::SeenGround> ground) {
  const std::size_t bytes = ground->bytes();
  entries_.push_front({digest, std::move(ground), bytes});
  bytes_ += bytes;
  while (bytes_ > max_bytes_ && entries_.size() > 1) {
    bytes_ -= entries_.back().bytes;
    entries_.pop_back();
  }
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/parked_mappings.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace enfilade::server {

std::vector<storage::SessionLease> ParkedMappings::Park(const storage::SessionLease& lease,
                                                        std::unique_ptr<SessionMapping> mapping) {
  const std::size_t bytes = mapping->bytes();
  std::list<Parked> evicted;  // freed after the lock is released
  std::vector<storage::SessionLease> unstored;
  MutexLock lock(mutex_);
  parked_.push_front({lease, std::move(mapping), bytes, false});
  bytes_ += bytes;
  while (bytes_ > max_bytes_ && parked_.size() > 1) {
    const auto next = NextToEvict();
    bytes_ -= next->bytes;
    if (!next->mapping->stored()) unstored.push_back(next->lease);
    evicted.splice(evicted.end(), parked_, next);
  }
  return unstored;
}

std::list<ParkedMappings::Parked>::iterator ParkedMappings::NextToEvict() {
  const auto oldest = std::prev(parked_.end());
  for (auto next = oldest; next != parked_.begin(); --next) {
    if (next->mapping->stored()) return next;
  }
  return oldest;
}

std::unique_ptr<SessionMapping> ParkedMappings::Take(const storage::LeasedSession& leased) {
  MutexLock lock(mutex_);
  const auto parked = std::find_if(parked_.begin(), parked_.end(), [&](const Parked& one) {
    return one.lease.site == leased.lease.site && one.lease.session == leased.lease.session;
  });
  if (parked == parked_.end()) return nullptr;
  std::unique_ptr<SessionMapping> mapping = std::move(parked->mapping);
  const bool is_current =
      leased.lease.token == parked->lease.token + 1 && leased.session.mapped_sequence == mapping->stored_sequence();
  bytes_ -= parked->bytes;
  parked_.erase(parked);
  return is_current ? std::move(mapping) : nullptr;
}

std::vector<storage::SessionLease> ParkedMappings::ListUnstored(
    const std::function<bool(const SessionMapping&)>& which) {
  std::vector<storage::SessionLease> listed;
  MutexLock lock(mutex_);
  for (Parked& parked : parked_) {
    if (parked.listed || parked.mapping->stored() || !which(*parked.mapping)) continue;
    parked.listed = true;
    listed.push_back(parked.lease);
  }
  return listed;
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "core/edit/map_edit.h"

namespace enfilade::server {

// Where somebody's pointer is in a draft.
struct DraftPresence {
  std::string client_id;
  std::string author;
  std::optional<edit::LatticePoint> pointer;
  std::string tool;
};

// Who looks at which draft, as this server has been told: a note for people, which is kept in memory. Thread-safe.
class DraftPresences {
 public:
  using Clock = std::chrono::steady_clock;

  void Report(const std::string& draft, DraftPresence presence) {
    const MutexLock lock(mutex_);
    Forget(Clock::now());
    Entry& entry = entries_[{draft, presence.client_id}];
    entry = {std::move(presence), Clock::now()};
    ++versions_[draft];
  }
  // By client.
  std::vector<DraftPresence> List(const std::string& draft) {
    const MutexLock lock(mutex_);
    Forget(Clock::now());
    std::vector<DraftPresence> presences;
    for (auto entry = entries_.lower_bound({draft, {}}); entry != entries_.end() && entry->first.first == draft;
         ++entry) {
      presences.push_back(entry->second.presence);
    }
    return presences;
  }
  // Grows with every change of what List gives; 0: nobody has been there.
  std::int64_t Version(const std::string& draft) {
    const MutexLock lock(mutex_);
    Forget(Clock::now());
    const auto found = versions_.find(draft);
    return found == versions_.end() ? 0 : found->second;
  }

 private:
  static constexpr auto kKept = std::chrono::seconds(15);

  struct Entry {
    DraftPresence presence;
    Clock::time_point time;
  };

  void Forget(Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    std::erase_if(entries_, [&](const auto& entry) {
      const bool is_old = now - entry.second.time > kKept;
      if (is_old) ++versions_[entry.first.first];
      return is_old;
    });
    if (entries_.empty() && versions_.size() > 1000) versions_.clear();
  }

  Mutex mutex_;
  std::map<std::pair<std::string, std::string>, Entry> entries_ ABSL_GUARDED_BY(mutex_);  // by draft and client
  std::map<std::string, std::int64_t> versions_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::server

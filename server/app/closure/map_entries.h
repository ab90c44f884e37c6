// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "proto/convert/names.h"
#include "server/app/runtime/stop_signal.h"
#include "server/app/runtime/wake_signal.h"
#include "storage/graph/door_verdict_store.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// The map that a session is mapped into, for its robot.
struct MapEntry {
  storage::Map map;
  sensor::SessionEntry entry;
  std::optional<closure::DoorVerdict> verdict;  // on the passage that the previous session ended with
};

// Notifies the streams of sessions that start behind a door of their map, once it is known. Thread-safe.
class MapEntries {
 public:
  MapEntries(const storage::SessionStore& sessions, const storage::MapStore& maps,
             const storage::DoorVerdictStore& verdicts);
  ~MapEntries();
  MapEntries(const MapEntries&) = delete;
  MapEntries& operator=(const MapEntries&) = delete;

  // Calls `on_entry` once, from a thread of this object, as soon as the session has a map; never if the session is
  // deleted first or `owner` is gone.
  void Await(const convert::SessionName& session, std::weak_ptr<const void> owner,
             std::function<void(const MapEntry&)> on_entry);
  // Call when sessions may have been assigned their map.
  void Wake() { wake_.Wake(); }

 private:
  struct Waiting {
    convert::SessionName session;
    std::weak_ptr<const void> owner;
    std::function<void(const MapEntry&)> on_entry;
  };

  void Run();
  // False if the session still has no map.
  bool Notify(const Waiting& waiting) const;

  const storage::SessionStore& sessions_;
  const storage::MapStore& maps_;
  const storage::DoorVerdictStore& verdicts_;
  Mutex mutex_;
  std::list<Waiting> waiting_ ABSL_GUARDED_BY(mutex_);
  WakeSignal wake_;
  StopSignal stop_;
  std::thread worker_;
};

}  // namespace enfilade::server

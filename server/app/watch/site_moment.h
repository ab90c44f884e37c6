// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "server/app/graph/pose_updates.h"
#include "server/app/watch/graph_view.h"
#include "storage/sites/activity_store.h"

namespace enfilade::server {

// Sessions and rasters at one moment. Immutable.
struct ActivityView {
  struct RemovedSession {
    SessionId id;
    std::uint64_t moment = 0;  // when it was missing first
    TimeNs time = 0;
  };

  std::uint64_t moment = 0;                      // counted since the first
  storage::SiteActivity activity;                // of its sessions all are there, none is deleted
  std::vector<RemovedSession> removed_sessions;  // lately
  // Equal if and, as good as certainly, only if the content is.
  std::uint64_t sessions_digest = 0;  // of those that are not over
  std::uint64_t revisions_digest = 0;
};

// The view after `before` (null: none): `before` itself if nothing has changed.
std::shared_ptr<const ActivityView> Following(const std::shared_ptr<const ActivityView>& before,
                                              storage::SiteActivity activity);

// A site at one moment, as all who watch it see it. Immutable and shared.
struct SiteMoment {
  std::shared_ptr<const SitePoses> poses;
  std::shared_ptr<const GraphView> graph;  // of the same version as the poses
  std::shared_ptr<const ActivityView> activity;

  friend bool operator==(const SiteMoment&, const SiteMoment&) = default;
};

}  // namespace enfilade::server

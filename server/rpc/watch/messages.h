// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/base/ids.h"
#include "enfilade/v1/watch_service.pb.h"
#include "server/app/watch/site_updates.h"

namespace enfilade::server {

// An update as messages of at most kMaxItems items each: removals, then maps, link points, rasters, sessions, robots.
class SiteMessages {
 public:
  static constexpr std::size_t kMaxItems = 1000;

  // No messages.
  SiteMessages() = default;
  SiteMessages(SiteId site, v1::RobotView view, SiteUpdate update);

  // All is written.
  bool done() const { return !first_ && remaining_ == 0; }
  // Writes the next part, without its token and time. Not after done().
  void Next(v1::WatchSiteResponse& out);

 private:
  void FillGraph(std::size_t& budget, v1::WatchSiteResponse& out);

  // The items of each list that have been written.
  struct Written {
    std::size_t removed_maps = 0;
    std::size_t removed_link_points = 0;
    std::size_t maps = 0;
    std::size_t link_points = 0;
    std::size_t revisions = 0;
    std::size_t removed_sessions = 0;
    std::size_t sessions = 0;
    std::size_t removed_robots = 0;
    std::size_t robots = 0;
  };

  SiteId site_;
  v1::RobotView view_ = v1::ROBOT_VIEW_BASIC;
  SiteUpdate update_;
  Written written_;
  std::size_t remaining_ = 0;  // items
  bool first_ = false;
};

}  // namespace enfilade::server

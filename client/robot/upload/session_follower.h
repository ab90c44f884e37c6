// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "client/robot/notification.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "enfilade/v1/door.pb.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "enfilade/v1/session.pb.h"
#include "proto/convert/names.h"

namespace enfilade::robot {

// Polls what the server makes of the sessions that it has received whole, and notifies of it: the map entered, the
// verdicts on doors, the end of mapping. Also of the robot's pose in the world. Not thread-safe.
class SessionFollower {
 public:
  // What is known outside of the follower.
  struct Hooks {
    // How many door reports, and so verdicts, a session has.
    std::function<int(const SessionId&)> expected_verdicts;
    // The map that a session entered; called once for each session.
    std::function<void(const SessionId&, const v1::MapEntered&)> on_map_entered;
  };

  SessionFollower(const client::Connection& connection, convert::RobotName robot, NotificationListener listener,
                  Hooks hooks);

  void Add(const SessionId& session) { sessions_.push_back({session}); }
  // Asks the server once about each session, and forgets those that are done: mapped, with all verdicts, and surveyed
  // if the server surveys sites. Of those that miss nothing but a survey only the first is asked for: a survey sees all
  // of them.
  void Poll();
  // Asks for the robot's pose in the world, and notifies if it has changed.
  void PollGlobalPose();
  std::int64_t size() const { return static_cast<std::int64_t>(sessions_.size()); }
  // Of these, how many are not mapped yet.
  std::int64_t unmapped() const;
  // Whether the server answered when it was last asked about a session.
  bool reachable() const { return reachable_; }

 private:
  struct Followed {
    SessionId session;
    int verdicts = 0;  // that were reported
    bool mapped = false;
    bool map_reported = false;
    bool awaits_survey = false;  // and nothing else
  };

  // False while the server does not say.
  bool ServerSurveys();
  bool PollSession(Followed& followed);  // true when nothing more will come
  void NotifyMapped(const Followed& followed, const v1::Session& session);
  void NotifyVerdict(const SessionId& session, const v1::DoorVerdict& verdict);
  std::string DisplayNameOf(const std::string& map);

  const client::Connection connection_;
  const convert::RobotName robot_;
  const NotificationListener listener_;
  const Hooks hooks_;
  std::deque<Followed> sessions_;
  bool reachable_ = true;
  std::optional<bool> server_surveys_;
  std::map<std::string, std::string> display_names_;  // by the map's resource name
  std::string last_global_pose_;
};

}  // namespace enfilade::robot

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "client/sdk/connection.h"
#include "tests/bench/fleet/recorded_drive.h"
#include "tests/bench/support/bench_system.h"

namespace enfilade::bench {

// The calls that a robot and its dashboard make, one after the other, at one site. Each returns how long each call
// took, ms, and throws if one fails.
class SiteCalls {
 public:
  // `site`: one that AddSites has made.
  SiteCalls(BenchSystem& system, std::string site, int maps);

  // Waits until the server has solved the graph again.
  void Settle() { system_.Settle(parent_); }

  std::vector<double> GetSite(int count);
  std::vector<double> FindLinkPoints(int count);
  std::vector<double> GetGlobalPose(int count);
  std::vector<double> SubmitScan(int count);
  // A batch of five scans on an open stream, until it is acknowledged.
  std::vector<double> StreamRecords(int count);
  // A map and a link point that joins it to one of the site's.
  std::vector<double> NewRoom(int count);
  // A link point is moved; until a pose far away is answered from the new graph.
  std::vector<double> PoseAfterChange(int count);
  // A robot drives from a room of the site through unknown doors; how long each verdict took, as the server says.
  std::vector<double> DoorVerdict(const RecordedDrive& drive, int sessions);

 private:
  std::vector<double> Time(int count, const std::function<void(int)>& call);
  std::string RandomRoom();  // its resource name
  std::string CreateSession(const std::string& robot);

  BenchSystem& system_;
  const client::Connection connection_;
  const std::string site_;
  const std::string parent_;
  const int maps_;
  std::uint64_t random_ = 1;
  int created_ = 0;
};

}  // namespace enfilade::bench

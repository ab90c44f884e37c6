// SPDX-License-Identifier: Apache-2.0
// usage: robot_client SERVER SITE SPOOL
// A robot's driver: records scans and odometry durably, while an uplink sends them to the server. The scans here are
// computed: the robot drives two metres through a square room. If the program is killed and started again with the same
// spool, what it recorded still reaches the server.
#include <chrono>
#include <cmath>
#include <iostream>

#include "client/sdk/spool/spool.h"
#include "client/sdk/uplink/uplink.h"

namespace {

using enfilade::TimeNs;
using enfilade::sensor::LaserScan;
using enfilade::sensor::Odometry;

constexpr double kHalfRoom = 4.0;  // m
constexpr int kBeams = 360;

enfilade::client::SpoolSession NewSession(const char* site) {
  enfilade::client::SpoolSession session;
  session.site = enfilade::SiteId(site);
  session.id = enfilade::SessionId("first-drive");
  session.robot = enfilade::RobotId("rover-1");
  session.map = "Square room";
  session.request_id = "2f0a4f3e-6f0e-4f57-8a0f-0f6c1d8f6b10";  // a UUID, kept for the session's whole life
  session.source = "robot_client";
  return session;
}

// The scan from (x, 0) along the x axis, in a room around the origin.
LaserScan ScanFrom(double x, TimeNs time) {
  LaserScan scan;
  scan.time = time;
  scan.angle_min = -M_PI;
  scan.angle_increment = 2.0 * M_PI / kBeams;
  scan.range_min = 0.1F;
  scan.range_max = 30.0F;
  for (int beam = 0; beam < kBeams; ++beam) {
    const double angle = scan.angle(static_cast<std::size_t>(beam));
    const double to_wall_x = ((std::cos(angle) > 0 ? kHalfRoom : -kHalfRoom) - x) / std::cos(angle);
    const double to_wall_y = kHalfRoom / std::abs(std::sin(angle));
    scan.ranges.push_back(static_cast<float>(std::min(to_wall_x, to_wall_y)));
  }
  return scan;
}

absl::Status Record(enfilade::client::Spool& spool, const enfilade::SessionId& session) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const TimeNs start = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  for (int step = 0; step <= 20; ++step) {
    const double x = 0.1 * step;
    const TimeNs time = start + step * TimeNs{100'000'000};
    for (const auto& stored : {spool.Append(session, Odometry{time, enfilade::Pose2(x, 0.0, 0.0)}),
                               spool.Append(session, ScanFrom(x, time))}) {
      if (!stored.ok()) return stored.status();  // RESOURCE_EXHAUSTED: the spool is full; try again later
    }
  }
  return spool.MarkFinished(session);
}

absl::Status Run(const char* server, const char* site, const char* spool_file) {
  auto spool = enfilade::client::Spool::Open(spool_file);
  if (!spool.ok()) return spool.status();
  const auto session = NewSession(site);
  if (!(*spool)->FindSession(session.id)) {
    if (const absl::Status created = (*spool)->CreateSession(session); !created.ok()) return created;
  }
  enfilade::client::Uplink uplink(enfilade::client::Connection(server, std::chrono::seconds(10)), **spool, session.id);
  uplink.Start();
  if (!(*spool)->FindSession(session.id)->finished) {
    if (const absl::Status recorded = Record(**spool, session.id); !recorded.ok()) return recorded;
  }
  const auto ended = uplink.WaitFor(std::chrono::minutes(1));
  if (!ended) return absl::UnavailableError(uplink.progress().last_error);
  if (ended->ok()) std::cout << "acknowledged: " << uplink.progress().acknowledged_sequence << " records\n";
  return *ended;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: robot_client SERVER SITE SPOOL\n";
    return 2;
  }
  if (const absl::Status status = Run(argv[1], argv[2], argv[3]); !status.ok()) {
    std::cerr << "robot_client: " << status << '\n';
    return 1;
  }
}

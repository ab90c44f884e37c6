// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "client/sdk/spool/spool.h"
#include "core/base/sha256.h"

namespace enfilade::testing {

// A scan that is unlike every other: its time and ranges tell its number.
inline sensor::LaserScan NumberedScan(int number, std::size_t beams = 180) {
  sensor::LaserScan scan;
  scan.time = 1'700'000'000'000'000'000 + number;
  scan.angle_min = -1.5;
  scan.angle_increment = 0.01;
  scan.range_min = 0.1F;
  scan.range_max = 30.0F;
  scan.ranges.assign(beams, 1.0F + 0.001F * static_cast<float>(number % 1000));
  return scan;
}

inline client::SpoolSession SampleSession(const std::string& id = "run-1") {
  client::SpoolSession session;
  session.site = SiteId("campus");
  session.id = SessionId(id);
  session.robot = RobotId("r1");
  session.map = "hall";
  session.request_id = "11111111-2222-4333-8444-555555555555";
  session.source = "test";
  return session;
}

inline client::SpoolItem ImageItem(const std::string& content) {
  sensor::Image image;
  image.time = 1'700'000'000'000'000'000;
  image.content = {Sha256(content), static_cast<std::int64_t>(content.size())};
  return {image, content};
}

}  // namespace enfilade::testing

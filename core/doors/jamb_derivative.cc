// SPDX-License-Identifier: Apache-2.0
#include "core/doors/jamb_derivative.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/pose2.h"
#include "fmt/format.h"

namespace enfilade::doors {
namespace {

double RangeOf(const sensor::LaserScan& scan, std::size_t beam) {
  switch (sensor::ClassifyBeam(scan, scan.ranges[beam])) {
    case sensor::BeamKind::kHit:
      return static_cast<double>(scan.ranges[beam]);
    case sensor::BeamKind::kNoReturn:
      return std::numeric_limits<double>::infinity();
    case sensor::BeamKind::kUnknown:
      break;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::size_t BeamsOf(const sensor::LaserScan& scan, double degrees) {
  const double beams = std::round(degrees * kDegree / std::abs(scan.angle_increment));
  return static_cast<std::size_t>(std::clamp(beams, 1.0, static_cast<double>(sensor::kMaxBeams)));
}

// Where the beams point, in the robot's frame, counter-clockwise: a scanner that turns clockwise is read backwards.
struct Order {
  const sensor::LaserScan& scan;
  std::size_t BeamAt(std::size_t i) const { return scan.angle_increment >= 0.0 ? i : scan.ranges.size() - 1 - i; }
  double BearingAt(std::size_t i) const { return WrapAngle(scan.angle(BeamAt(i)) + scan.T_robot_laser.yaw); }
};

struct Posts {
  std::vector<double> ranges;  // counter-clockwise
  std::vector<double> derivative;
  std::size_t offset;

  bool OnPost(std::size_t i, const DerivativeOptions& options) const {
    const double range = ranges[i > offset ? i - offset : 0];
    return range > options.post_min && range < options.post_max;
  }
};

Posts PostsOf(const sensor::LaserScan& scan, const DerivativeOptions& options) {
  const Order order{scan};
  Posts posts;
  posts.offset = BeamsOf(scan, options.post_offset);
  const std::size_t beams = scan.ranges.size();
  for (std::size_t i = 0; i < beams; ++i) posts.ranges.push_back(RangeOf(scan, order.BeamAt(i)));
  const std::size_t window = BeamsOf(scan, options.half_window);
  for (std::size_t i = 0; i < beams; ++i) {
    const double behind = posts.ranges[std::min(beams - 1, i + window)];
    const double before = posts.ranges[i > window ? i - window : 0];
    posts.derivative.push_back((behind - before) / 2.0);
  }
  return posts;
}

std::string NoPosts(const char* which) { return fmt::format("no {} post: D stays below the threshold there", which); }

JambSearch Judge(JambSearch search, const JambPair& pair, const DerivativeOptions& options) {
  const double opening = pair.opening / kDegree;
  if (opening > options.opening_min && opening < options.opening_max) {
    search.jambs = pair;
    search.reason = fmt::format("posts {:.0f} deg apart", opening);
  } else {
    search.reason = fmt::format("posts {:.0f} deg apart: not within {:.0f} to {:.0f}", opening, options.opening_min,
                                options.opening_max);
  }
  return search;
}

}  // namespace

std::vector<double> ScanDerivative(const sensor::LaserScan& scan, const DerivativeOptions& options) {
  std::vector<double> derivative = PostsOf(scan, options).derivative;
  if (scan.angle_increment < 0.0) std::reverse(derivative.begin(), derivative.end());
  return derivative;
}

JambSearch FindJambsAhead(const sensor::LaserScan& scan, const DerivativeOptions& options) {
  const Order order{scan};
  const Posts posts = PostsOf(scan, options);
  JambSearch search;
  std::optional<std::size_t> right;
  std::optional<std::size_t> left;
  for (std::size_t i = 0; i < posts.ranges.size(); ++i) {
    if (std::abs(order.BearingAt(i)) > options.front_sector * kDegree) continue;
    search.sector_in_view = true;
    if (!posts.OnPost(i, options)) continue;
    if (!right && posts.derivative[i] > options.threshold) right = i;
    if (right && !left && posts.derivative[i] < -options.threshold) left = i;
  }
  if (!search.sector_in_view) search.reason = "the scanner does not look ahead";
  if (!right || !left) {
    if (search.reason.empty()) search.reason = NoPosts(right ? "left" : "right");
    return search;
  }
  JambPair pair{order.BearingAt(*right), order.BearingAt(*left), 0.0};
  pair.opening = pair.left - pair.right;
  return Judge(std::move(search), pair, options);
}

JambSearch FindJambsBehind(const sensor::LaserScan& scan, const DerivativeOptions& options) {
  const Order order{scan};
  const Posts posts = PostsOf(scan, options);
  JambSearch search;
  // In the scan's order the gap behind lies at both its ends: first it ends (D falls), later it begins (D rises).
  std::optional<std::size_t> gap_ends;
  std::optional<std::size_t> gap_begins;
  bool left_side = false;
  bool right_side = false;
  for (std::size_t i = 0; i < posts.ranges.size(); ++i) {
    const double bearing = order.BearingAt(i);
    if (std::abs(bearing) < options.back_sector * kDegree) continue;
    (bearing > 0.0 ? left_side : right_side) = true;
    if (!posts.OnPost(i, options)) continue;
    if (!gap_ends && posts.derivative[i] < -options.threshold) gap_ends = i;
    if (gap_ends && !gap_begins && posts.derivative[i] > options.threshold) gap_begins = i;
  }
  search.sector_in_view = left_side && right_side;
  if (!search.sector_in_view) {
    search.reason = "the scanner does not look back";
    return search;
  }
  if (!gap_ends || !gap_begins) {
    search.reason = NoPosts(gap_ends ? "second" : "first");
    return search;
  }
  JambPair pair{order.BearingAt(*gap_begins), order.BearingAt(*gap_ends), 0.0};
  pair.opening = WrapAngle(pair.left - pair.right);
  if (pair.opening < 0.0) pair.opening += 2.0 * M_PI;
  return Judge(std::move(search), pair, options);
}

}  // namespace enfilade::doors

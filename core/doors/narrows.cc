// SPDX-License-Identifier: Apache-2.0
#include "core/doors/narrows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fmt/format.h"

namespace enfilade::doors {
namespace {

constexpr double kBin = 0.05;       // m along the way
constexpr double kAsNarrow = 0.15;  // m above the least width still count as narrow
constexpr double kUsual = 2.5;      // m before and behind: the way whose usual width is compared
constexpr double kNever = std::numeric_limits<double>::infinity();

struct Side {
  double along;  // m along the way
  double aside;  // m from it, positive
  Eigen::Vector2d point;
};

struct Profile {
  double first = 0.0;  // m along the way of the first bin
  std::vector<double> widths;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> posts;  // left, right

  std::size_t BinOf(double along) const {
    const double bin = std::floor((along - first) / kBin);
    return static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(widths.size()) - 1.0));
  }
  double AlongOf(std::size_t bin) const { return first + (static_cast<double>(bin) + 0.5) * kBin; }
};

struct Sides {
  std::vector<Side> left;  // sorted along the way, as the right ones
  std::vector<Side> right;
};

// The surfaces beside the way, up to `widest` m off, that lie within the profile.
Sides FindSides(const LocalMap& map, const StraightWay& way, const Profile& profile, double widest) {
  const double length = static_cast<double>(profile.widths.size()) * kBin;
  const Eigen::Vector2d middle = way.origin + (profile.first + length / 2.0) * way.direction;
  Sides sides;
  for (const Eigen::Vector2d& point : map.SurfaceWithin(middle, length / 2.0 + widest)) {
    const Eigen::Vector2d to = point - way.origin;
    const double along = way.direction.dot(to);
    const double aside = way.direction.x() * to.y() - way.direction.y() * to.x();
    if (std::abs(aside) > widest || std::abs(aside) < 0.02) continue;
    (aside > 0.0 ? sides.left : sides.right).push_back({along, std::abs(aside), point});
  }
  const auto by_along = [](const Side& a, const Side& b) { return a.along < b.along; };
  std::sort(sides.left.begin(), sides.left.end(), by_along);
  std::sort(sides.right.begin(), sides.right.end(), by_along);
  return sides;
}

// The least distance between both sides at each place of the way.
Profile MeasureWidths(const LocalMap& map, const StraightWay& way, const GapOptions& options) {
  Profile profile;
  const double beside = std::max(options.shoulder, kUsual);
  profile.first = way.begin - beside;
  const auto bins = static_cast<std::size_t>(std::ceil((way.end - way.begin + 2.0 * beside) / kBin));
  profile.widths.assign(bins, kNever);
  profile.posts.resize(bins);
  const double widest = options.max_width + options.widening + kAsNarrow;
  const auto [left, right] = FindSides(map, way, profile, widest);
  const double steepest = std::tan((90.0 - options.min_angle) * M_PI / 180.0);
  std::size_t start = 0;
  for (const Side& l : left) {
    while (start < right.size() && right[start].along < l.along - widest) ++start;
    for (std::size_t i = start; i < right.size() && right[i].along <= l.along + widest; ++i) {
      const Side& r = right[i];
      const double across = l.aside + r.aside;
      const double ahead = r.along - l.along;
      if (across > widest || std::abs(ahead) > across * steepest) continue;
      const double width = std::sqrt(across * across + ahead * ahead);
      const double along = l.along + ahead * l.aside / across;
      const double bin = std::floor((along - profile.first) / kBin);
      if (bin < 0.0 || bin >= static_cast<double>(bins)) continue;
      const auto at = static_cast<std::size_t>(bin);
      if (width >= profile.widths[at]) continue;
      profile.widths[at] = width;
      profile.posts[at] = {l.point, r.point};
    }
  }
  return profile;
}

// The largest width within `shoulder` on one side of a bin, 0.2 m off at least.
double WidestBeside(const Profile& profile, std::size_t bin, int side, double shoulder) {
  double widest = 0.0;
  for (double off = 0.2; off <= shoulder; off += kBin) {
    const double along = profile.AlongOf(bin) + side * off;
    if (along < profile.first || along >= profile.first + kBin * static_cast<double>(profile.widths.size())) break;
    widest = std::max(widest, profile.widths[profile.BinOf(along)]);
  }
  return widest;
}

// How much of the way around a bin, m, is just as wide.
double RepeatedAbout(const Profile& profile, std::size_t bin) {
  constexpr double kOff = 0.6;    // m: nearer, it is the same narrow place
  constexpr double kSame = 0.12;  // m
  int bins = 0;
  for (std::size_t i = 0; i < profile.widths.size(); ++i) {
    const double off = std::abs(profile.AlongOf(i) - profile.AlongOf(bin));
    if (off >= kOff && off <= kUsual && std::abs(profile.widths[i] - profile.widths[bin]) < kSame) ++bins;
  }
  return bins * kBin;
}

double DepthAt(const Profile& profile, std::size_t bin) {
  const double limit = profile.widths[bin] + kAsNarrow;
  std::size_t begin = bin;
  std::size_t end = bin;
  // A single empty bin between two narrow ones does not end the narrow place.
  const auto narrow = [&](std::size_t i) { return profile.widths[i] <= limit; };
  while (begin > 0 && (narrow(begin - 1) || (begin > 1 && narrow(begin - 2)))) --begin;
  while (end + 1 < profile.widths.size() && (narrow(end + 1) || (end + 2 < profile.widths.size() && narrow(end + 2))))
    ++end;
  return static_cast<double>(end - begin + 1) * kBin;
}

// Is the way narrowest here within four bins? The first of equals is.
bool IsLocalMinimum(const Profile& profile, std::size_t bin) {
  const double width = profile.widths[bin];
  for (std::size_t i = bin > 4 ? bin - 4 : 0; i <= std::min(bin + 4, profile.widths.size() - 1); ++i) {
    if (profile.widths[i] < width || (i < bin && profile.widths[i] == width)) return false;
  }
  return true;
}

// Judges a local minimum of the width.
NarrowsSearch JudgeMinimum(const Profile& profile, std::size_t bin, const GapOptions& options) {
  NarrowsSearch search;
  const double width = profile.widths[bin];
  const double before = WidestBeside(profile, bin, -1, options.shoulder) - width;
  const double behind = WidestBeside(profile, bin, 1, options.shoulder) - width;
  if (before < options.widening || behind < options.widening) {
    search.reason = fmt::format("{:.2f} m wide, but the way widens by {:.2f} m before and {:.2f} m behind only", width,
                                before, behind);
    return search;
  }
  const double depth = DepthAt(profile, bin);
  if (depth > options.max_depth) {
    search.reason = fmt::format("{:.2f} m wide, but over {:.2f} m of the way: a passage, no door", width, depth);
    return search;
  }
  const double repeated = RepeatedAbout(profile, bin);
  if (repeated >= options.repeated) {
    search.reason =
        fmt::format("{:.2f} m wide, but so is {:.2f} m of the way about it: its usual width", width, repeated);
    return search;
  }
  search.reason = fmt::format("{:.2f} m wide, {:.2f} m deep", width, depth);
  search.narrows = Narrows{profile.posts[bin].first, profile.posts[bin].second, profile.AlongOf(bin), depth};
  return search;
}

}  // namespace

NarrowsSearch FindNarrows(const LocalMap& map, const StraightWay& way, const GapOptions& options) {
  const Profile profile = MeasureWidths(map, way, options);
  NarrowsSearch search;
  search.reason = "nothing narrow on the way";
  const std::size_t first = profile.BinOf(way.begin);
  const std::size_t last = profile.BinOf(way.end);
  for (std::size_t bin = first; bin <= last; ++bin) {
    const double width = profile.widths[bin];
    if (width > options.max_width || width < options.min_width - 2.0 * options.cell) continue;
    if (!IsLocalMinimum(profile, bin)) continue;
    search = JudgeMinimum(profile, bin, options);
    if (search.narrows) return search;
  }
  return search;
}

}  // namespace enfilade::doors

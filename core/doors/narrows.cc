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

Profile ProfileOf(const LocalMap& map, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction, double begin,
                  double end, const GapOptions& options) {
  Profile profile;
  const double beside = std::max(options.shoulder, kUsual);
  profile.first = begin - beside;
  const auto bins = static_cast<std::size_t>(std::ceil((end - begin + 2.0 * beside) / kBin));
  profile.widths.assign(bins, kNever);
  profile.posts.resize(bins);
  const double length = static_cast<double>(bins) * kBin;
  const Eigen::Vector2d middle = origin + (profile.first + length / 2.0) * direction;
  const double widest = options.max_width + options.widening + kAsNarrow;
  std::vector<Side> left;
  std::vector<Side> right;
  for (const Eigen::Vector2d& point : map.SurfaceWithin(middle, length / 2.0 + widest)) {
    const Eigen::Vector2d to = point - origin;
    const double along = direction.dot(to);
    const double aside = direction.x() * to.y() - direction.y() * to.x();
    if (std::abs(aside) > widest || std::abs(aside) < 0.02) continue;
    (aside > 0.0 ? left : right).push_back({along, std::abs(aside), point});
  }
  const auto by_along = [](const Side& a, const Side& b) { return a.along < b.along; };
  std::sort(left.begin(), left.end(), by_along);
  std::sort(right.begin(), right.end(), by_along);
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

// The widest place within `shoulder` on one side of a bin, a hand's breadth off.
double WidestBeside(const Profile& profile, std::size_t bin, int side, double shoulder) {
  double widest = 0.0;
  for (double off = 0.2; off <= shoulder; off += kBin) {
    const double along = profile.AlongOf(bin) + side * off;
    if (along < profile.first || along >= profile.first + kBin * static_cast<double>(profile.widths.size())) break;
    widest = std::max(widest, profile.widths[profile.BinOf(along)]);
  }
  return widest;
}

// How much of the way about a bin, m, is just as wide.
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

}  // namespace

NarrowsSearch FindNarrows(const LocalMap& map, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                          double begin, double end, const GapOptions& options) {
  const Profile profile = ProfileOf(map, origin, direction, begin, end, options);
  NarrowsSearch search;
  search.reason = "nothing narrow on the way";
  const std::size_t first = profile.BinOf(begin);
  const std::size_t last = profile.BinOf(end);
  for (std::size_t bin = first; bin <= last; ++bin) {
    const double width = profile.widths[bin];
    if (width > options.max_width || width < options.min_width - 2.0 * options.cell) continue;
    // The least within a hand's breadth.
    bool least = true;
    for (std::size_t i = bin > 4 ? bin - 4 : 0; i <= std::min(bin + 4, profile.widths.size() - 1); ++i) {
      least = least && profile.widths[i] >= width && !(i < bin && profile.widths[i] == width);
    }
    if (!least) continue;
    const double before = WidestBeside(profile, bin, -1, options.shoulder) - width;
    const double behind = WidestBeside(profile, bin, 1, options.shoulder) - width;
    const double depth = DepthAt(profile, bin);
    if (before < options.widening || behind < options.widening) {
      search.reason = fmt::format("{:.2f} m wide, but the way widens by {:.2f} m before and {:.2f} m behind only",
                                  width, before, behind);
      continue;
    }
    if (depth > options.max_depth) {
      search.reason = fmt::format("{:.2f} m wide, but over {:.2f} m of the way: a passage, no door", width, depth);
      continue;
    }
    const double repeated = RepeatedAbout(profile, bin);
    if (repeated >= options.repeated) {
      search.reason =
          fmt::format("{:.2f} m wide, but so is {:.2f} m of the way about it: its usual width", width, repeated);
      continue;
    }
    Narrows narrows{profile.posts[bin].first, profile.posts[bin].second, profile.AlongOf(bin), depth};
    search.reason = fmt::format("{:.2f} m wide, {:.2f} m deep", width, depth);
    search.narrows = narrows;
    return search;
  }
  return search;
}

}  // namespace enfilade::doors

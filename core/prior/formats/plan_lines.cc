// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/plan_lines.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/base/error.h"
#include "core/prior/plan/plan_check.h"

namespace enfilade::prior {
namespace {

// Patterns of n characters against names of m take n * m steps at most: only the last * is tried again.
bool MatchesPattern(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, mark = 0;
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  while (n < name.size()) {
    if (p < pattern.size() && (pattern[p] == '?' || (pattern[p] != '*' && same(pattern[p], name[n])))) {
      ++p;
      ++n;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      mark = n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++mark;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

}  // namespace

bool IsWantedLayer(const std::vector<std::string>& patterns, std::string_view layer) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                         [&](const std::string& pattern) { return MatchesPattern(pattern, layer); });
}

void PlanLines::Add(const Eigen::Affine2d& T, const std::vector<Eigen::Vector2d>& points, bool closed,
                    double thickness) {
  if (!status_.ok() || points.size() < 2) return;
  if (plan_.walls.size() + points.size() > kMostWalls) {
    status_ = ResourceExhausted("more than {} lines: choose layers, or divide the plan", kMostWalls);
    return;
  }
  const std::size_t count = closed ? points.size() : points.size() - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d a = T * points[i], b = T * points[(i + 1) % points.size()];
    if (!a.allFinite() || !b.allFinite() || a.cwiseAbs().maxCoeff() > 1e12 || b.cwiseAbs().maxCoeff() > 1e12) {
      status_ = InvalidArgument("a line has a coordinate that is not finite, or beyond 1e12");
      return;
    }
    if (!((b - a).norm() > 0)) continue;
    const int from = static_cast<int>(plan_.corners.size());
    plan_.corners.push_back({a});
    plan_.corners.push_back({b});
    plan_.walls.push_back({.from = from, .to = from + 1, .thickness = std::isfinite(thickness) ? thickness : 0});
  }
}

std::vector<Eigen::Vector2d> ChordsOf(const Eigen::Vector2d& radii, double from, double sweep, double sagitta) {
  double step = M_PI / 24;
  const double radius = radii.cwiseAbs().maxCoeff();
  if (sagitta > 0 && radius > sagitta) step = 2 * std::acos(1 - sagitta / radius);
  const int count = std::clamp(static_cast<int>(std::ceil(std::abs(sweep) / std::max(step, 1e-3))), 1, 720);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= count; ++i) {
    const double angle = from + sweep * i / count;
    points.emplace_back(radii.x() * std::cos(angle), radii.y() * std::sin(angle));
  }
  return points;
}

}  // namespace enfilade::prior

// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/directions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/pose2.h"

namespace enfilade::prior {
namespace {

constexpr int kBins = 180;                   // of half a degree
constexpr double kBin = 0.5 * M_PI / kBins;  // rad
constexpr double kDirectionSigma = 1.5 * kDegree;
constexpr int kBinsApart = 8;         // bins between two turns
constexpr double kLeastLikely = 0.6;  // of the best
constexpr std::size_t kMostTurns = 3;

using Histogram = std::array<double, kBins>;

int BinOf(double angle) {
  const double turns = angle / (0.5 * M_PI);
  return static_cast<int>((turns - std::floor(turns)) * kBins) % kBins;
}

Histogram Smoothed(const Histogram& histogram) {
  constexpr int kReach = 10;
  Histogram smooth{};
  for (int i = 0; i < kBins; ++i) {
    for (int d = -kReach; d <= kReach; ++d) {
      const double distance = d * kBin / kDirectionSigma;
      smooth[(i + d + kBins) % kBins] += histogram[i] * std::exp(-0.5 * distance * distance);
    }
  }
  return smooth;
}

Histogram OfPlan(const std::vector<WallFace>& faces, bool mirrored) {
  Histogram histogram{};
  for (const WallFace& face : faces) {
    const Eigen::Vector2d way = face.to - face.from;
    histogram[BinOf(std::atan2(mirrored ? way.y() : -way.y(), way.x()))] += way.norm();
  }
  return Smoothed(histogram);
}

Histogram OfMap(const MapEvidence& evidence) {
  Histogram histogram{};
  for (const WallPoint& wall : evidence.walls) {
    histogram[BinOf(std::atan2(wall.along.y(), wall.along.x()))] += wall.straightness * wall.straightness;
  }
  return Smoothed(histogram);
}

}  // namespace

std::vector<double> LikelyTurns(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, bool mirrored) {
  const Histogram plan = OfPlan(faces_sheet, mirrored);
  const Histogram map = OfMap(evidence);
  Histogram fit{};
  for (int turn = 0; turn < kBins; ++turn) {
    for (int i = 0; i < kBins; ++i) fit[turn] += plan[i] * map[(i + turn) % kBins];
  }
  std::vector<int> order(kBins);
  for (int i = 0; i < kBins; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return fit[a] > fit[b]; });
  std::vector<int> chosen;
  for (const int turn : order) {
    if (chosen.size() == kMostTurns || fit[turn] < kLeastLikely * fit[order.front()]) break;
    const bool is_peak = fit[turn] >= fit[(turn + 1) % kBins] && fit[turn] >= fit[(turn + kBins - 1) % kBins];
    const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](int other) {
      const int apart = std::abs(other - turn);
      return std::min(apart, kBins - apart) < kBinsApart;
    });
    if (is_peak && is_new) chosen.push_back(turn);
  }
  std::vector<double> turns;
  for (const int turn : chosen) turns.push_back(turn * kBin);
  return turns;
}

double MainDirection(const std::vector<WallFace>& faces_sheet) {
  const Histogram plan = OfPlan(faces_sheet, true);
  return static_cast<double>(std::max_element(plan.begin(), plan.end()) - plan.begin()) * kBin;
}

}  // namespace enfilade::prior

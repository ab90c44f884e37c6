// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/wall_line.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace enfilade::prior {
namespace {

constexpr double kSlot = 0.2;           // m, at most
constexpr std::size_t kMostTried = 24;  // samples that lines are laid through
constexpr double kLeastBase = 0.4;      // of a wall's length, between two samples that tell its direction
constexpr int kRefinements = 2;
constexpr double kClear = 0.15;     // m: so near to a wall of the map is no free ground
constexpr double kDeviation = 0.5;  // m of support that an end which is off by `reach` has to make up for

class LineFinder {
 public:
  LineFinder(const WallFace& centre, const std::vector<WallSample>& samples, double reach, const MapEvidence& evidence)
      : centre_(centre),
        samples_(samples),
        reach_(reach),
        evidence_(evidence),
        length_((centre.to - centre.from).norm()),
        count_(static_cast<std::size_t>(std::max(1.0, std::ceil(length_ / std::max(kSlot, evidence.spacing))))) {}

  WallLine Run() {
    best_ = Supported(0, 0);
    AddContradicted(best_);
    const std::size_t stride = samples_.size() / kMostTried + 1;
    for (std::size_t i = 0; i < samples_.size(); i += stride) {
      Try(samples_[i].across, samples_[i].across);
      for (std::size_t j = 0; j < i; j += stride) TryThrough(samples_[i], samples_[j]);
    }
    for (int i = 0; i < kRefinements; ++i) Refine();
    return std::move(best_);
  }

 private:
  void TryThrough(const WallSample& a, const WallSample& b) {
    if (std::abs(a.at - b.at) < kLeastBase * length_) return;
    const double slope = (a.across - b.across) / (a.at - b.at);
    Try(a.across - slope * a.at, a.across + slope * (length_ - a.at));
  }

  bool IsPossible(double from, double to) const { return std::max(std::abs(from), std::abs(to)) <= 2 * reach_; }

  void Try(double from, double to) {
    if (!IsPossible(from, to)) return;
    WallLine line = Supported(from, to);
    if (Score(line) <= Score(best_)) return;  // contradicted or not
    AddContradicted(line);
    if (Score(line) > Score(best_)) best_ = std::move(line);
  }

  // Lines through two samples are as inexact as these.
  void Refine() {
    double weight = 0, at = 0, across = 0, at_at = 0, at_across = 0;
    for (const WallSample& sample : samples_) {
      if (!IsOn(best_, sample)) continue;
      weight += 1;
      at += sample.at;
      across += sample.across;
      at_at += sample.at * sample.at;
      at_across += sample.at * sample.across;
    }
    if (weight < 2) return;
    const double spread = at_at - at * at / weight;
    // A short piece of a wall tells its place, not its direction.
    const bool tells_direction = std::sqrt(12 * spread / weight) > kLeastBase * length_;
    const double slope =
        tells_direction ? (at_across - at * across / weight) / spread : (best_.to - best_.from) / length_;
    const double from = (across - slope * at) / weight;
    const double to = from + slope * length_;
    if (!IsPossible(from, to)) return;
    best_ = Supported(from, to);
    AddContradicted(best_);
  }

  bool IsOn(const WallLine& line, const WallSample& sample) const {
    return std::abs(sample.across - line.AcrossAt(sample.at / length_)) <= kOnLine;
  }

  WallLine Supported(double from, double to) const {
    WallLine line{.from = from, .to = to, .slots = std::vector<std::uint8_t>(count_, 0)};
    const double slot = length_ / static_cast<double>(count_);
    const auto slot_at = [&](double at) {
      return static_cast<std::size_t>(std::clamp(at / slot, 0.0, static_cast<double>(count_ - 1)));
    };
    for (const WallSample& sample : samples_) {
      if (!IsOn(line, sample)) continue;
      const std::size_t last = slot_at(sample.at + evidence_.spacing);
      for (std::size_t i = slot_at(sample.at - evidence_.spacing); i <= last; ++i) line.slots[i] = 1;
    }
    line.supported = slot * static_cast<double>(std::count(line.slots.begin(), line.slots.end(), 1));
    return line;
  }

  void AddContradicted(WallLine& line) const {
    const Eigen::Vector2d along = (centre_.to - centre_.from).normalized();
    const Eigen::Vector2d left(-along.y(), along.x());
    for (std::size_t i = 0; i < count_; ++i) {
      if (line.slots[i] != 0) continue;
      const double fraction = (static_cast<double>(i) + 0.5) / static_cast<double>(count_);
      const Eigen::Vector2d middle =
          centre_.from + fraction * (centre_.to - centre_.from) + line.AcrossAt(fraction) * left;
      if (evidence_.GroundAt(middle) == Ground::kFree && evidence_.WallDistanceAt(middle) > kClear) {
        line.contradicted += length_ / static_cast<double>(count_);
      }
    }
  }

  double Score(const WallLine& line) const {
    const double deviation = (line.from * line.from + line.to * line.to) / (reach_ * reach_);
    return line.supported - line.contradicted - kDeviation * deviation;
  }

  const WallFace& centre_;
  const std::vector<WallSample>& samples_;
  const double reach_;
  const MapEvidence& evidence_;
  const double length_;
  const std::size_t count_;
  WallLine best_;
};

}  // namespace

std::optional<WallSample> SampleOf(const Eigen::Vector2d& point, const NearestFace& nearest, const WallFace& face) {
  if (nearest.fraction <= 0 || nearest.fraction >= 1) return std::nullopt;
  const Eigen::Vector2d left(-nearest.along.y(), nearest.along.x());
  return WallSample{nearest.fraction * (face.to - face.from).norm(), left.dot(point - nearest.point)};
}

double WallLine::SupportedShare(double begin, double end) const {
  const auto count = static_cast<double>(slots.size());
  const auto first = static_cast<std::size_t>(std::clamp(begin * count, 0.0, count - 1));
  const auto last = static_cast<std::size_t>(std::clamp(std::ceil(end * count), first + 1.0, count));
  double supported_slots = 0;
  for (std::size_t i = first; i < last; ++i) supported_slots += slots[i];
  return supported_slots / static_cast<double>(last - first);
}

WallLine LikeliestLine(const WallFace& centre, const std::vector<WallSample>& samples, double reach,
                       const MapEvidence& evidence) {
  return LineFinder(centre, samples, reach, evidence).Run();
}

}  // namespace enfilade::prior

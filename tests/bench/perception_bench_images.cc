// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "fmt/format.h"
#include "perception/image/decode.h"
#include "perception/image/match_images.h"
#include "tests/bench/perception_bench.h"
#include "tests/support/corridor.h"

namespace enfilade::bench {
namespace {

using perception::FeatureSet;

FeatureSet FeaturesOf(const std::string& bytes) {
  return perception::ExtractFeatures(perception::DecodeGrey(bytes).value()).value();
}

int Inliers(const FeatureSet& a, const FeatureSet& b, bool& accepted) {
  const perception::ImageMatch match = perception::MatchImages(a, b).value();
  accepted = match.accepted;
  return match.inliers;
}

// Accepted of tried.
struct Share {
  int accepted = 0;
  int pairs = 0;

  void Add(bool is_accepted) {
    accepted += is_accepted ? 1 : 0;
    ++pairs;
  }
  nlohmann::json json() const { return {{"accepted", accepted}, {"pairs", pairs}}; }
};

}  // namespace

// Image i shows the place of image i + 40; places at least four frames apart are different ones.
nlohmann::json MeasureCorridor(const std::filesystem::path& data) {
  std::map<int, std::string> files;
  for (int i = 1; i <= 84; ++i) {
    const std::filesystem::path path = data / "images/rtabmap_samples" / (std::to_string(i) + ".jpg");
    if (std::filesystem::exists(path)) files[i] = ReadAll(path);
  }
  if (files.empty()) return nullptr;
  std::map<int, FeatureSet> features;
  for (const auto& [i, bytes] : files) features[i] = FeaturesOf(bytes);
  Share same;
  Share different;
  int most_different = 0;
  for (const auto& [i, a] : features) {
    for (const auto& [j, b] : features) {
      const bool is_same = j - i == 40;
      if (j <= i || (!is_same && std::abs((i - 1) % 40 - (j - 1) % 40) < 4)) continue;
      bool accepted = false;
      const int inliers = Inliers(a, b, accepted);
      (is_same ? same : different).Add(accepted);
      if (!is_same) most_different = std::max(most_different, inliers);
    }
  }
  // A pair of each of the places, in turn: one image new, one known; then both known.
  std::vector<std::pair<int, int>> pairs;
  for (const auto& [i, bytes] : files) {
    if (files.contains(i + 40)) pairs.emplace_back(i, i + 40);
  }
  std::size_t next = 0;
  bool accepted = false;
  const nlohmann::json one_cached = Time(200, [&] {
    const auto& [i, j] = pairs[next++ % pairs.size()];
    Inliers(features[i], FeaturesOf(files[j]), accepted);
  });
  const nlohmann::json both_cached = Time(200, [&] {
    const auto& [i, j] = pairs[next++ % pairs.size()];
    Inliers(features[i], features[j], accepted);
  });
  return {{"same_place", same.json()},
          {"different_places", different.json()},
          {"most_inliers_of_different_places", most_different},
          {"one_cached", one_cached},
          {"both_cached", both_cached}};
}

nlohmann::json MeasureSimulatedCorridors() {
  constexpr std::uint64_t kFirst = 201000;  // not those of development and tests
  constexpr std::uint64_t kCorridors = 40;
  Share same;
  std::map<std::string, Share> ahead;
  bool accepted = false;
  for (std::uint64_t i = 0; i < kCorridors; ++i) {
    const testing::Corridor corridor(kFirst + 1000 * i);
    for (std::uint64_t k = 0; k < 2; ++k) {
      const testing::CorridorPair twice = testing::SeeSamePlaceTwice(corridor, 100 * i + k);
      Inliers(twice.a, twice.b, accepted);
      same.Add(accepted);
      for (const double metres : {0.5, 1.0, 2.0, 3.0, 4.0, 6.0}) {
        const testing::CorridorPair pair = testing::SeeFromAhead(corridor, metres, 100 * i + 50 + k);
        Inliers(pair.a, pair.b, accepted);
        ahead[fmt::format("{:.1f} m", metres)].Add(accepted);
      }
    }
  }
  nlohmann::json document = {{"same_place", same.json()}};
  for (const auto& [distance, share] : ahead) document["ahead"][distance] = share.json();
  return document;
}

nlohmann::json MeasureWideBaselines(const std::filesystem::path& data) {
  const std::filesystem::path folder = data / "images/scannet_pairs";
  if (!std::filesystem::exists(folder)) return nullptr;
  std::ifstream list(folder / "scannet_sample_pairs_with_gt.txt");
  Share same;
  for (std::string line; std::getline(list, line);) {
    std::istringstream words(line);
    std::string a;
    std::string b;
    words >> a >> b;
    if (!std::filesystem::exists(folder / a) || !std::filesystem::exists(folder / b)) continue;
    bool accepted = false;
    Inliers(FeaturesOf(ReadAll(folder / a)), FeaturesOf(ReadAll(folder / b)), accepted);
    same.Add(accepted);
  }
  return same.json();
}

namespace {

struct PosedFrame {
  FeatureSet features;
  perception::DepthFrame depth;
  Eigen::Matrix4d T_world_camera = Eigen::Matrix4d::Identity();
};

constexpr double kFocal = 585.0;  // pixels, of the recording's camera-intrinsics.txt
constexpr double kCenterX = 320.0;
constexpr double kCenterY = 240.0;

// The share of a's measured pixels (every 16th) that b sees at the same depth within a tenth.
double Overlap(const PosedFrame& a, const PosedFrame& b) {
  const Eigen::Matrix4d T_b_a = b.T_world_camera.inverse() * a.T_world_camera;
  int measured = 0;
  int seen = 0;
  for (int v = 8; v < a.depth.height; v += 16) {
    for (int u = 8; u < a.depth.width; u += 16) {
      const double z = a.depth.metres[static_cast<std::size_t>(v * a.depth.width + u)];
      if (z < 0.1 || z > 30.0) continue;
      ++measured;
      const Eigen::Vector4d p =
          T_b_a * Eigen::Vector4d((u - kCenterX) * z / kFocal, (v - kCenterY) * z / kFocal, z, 1.0);
      const long column = std::lround(p.x() * kFocal / p.z() + kCenterX);
      const long row = std::lround(p.y() * kFocal / p.z() + kCenterY);
      if (p.z() < 0.1 || column < 0 || row < 0 || column >= b.depth.width || row >= b.depth.height) continue;
      const double depth = b.depth.metres[static_cast<std::size_t>(row * b.depth.width + column)];
      if (depth > 0.0 && std::abs(depth - p.z()) < 0.1 * p.z()) ++seen;
    }
  }
  return measured > 0 ? static_cast<double>(seen) / measured : 0.0;
}

}  // namespace

nlohmann::json MeasureOverlaps(const std::filesystem::path& data) {
  std::vector<PosedFrame> frames;
  for (int i = 0; i < 1000; ++i) {
    std::string number = std::to_string(i);
    number.insert(0, 6 - number.size(), '0');
    const std::string stem = data / "images/sevenscenes" / ("frame-" + number);
    if (!std::filesystem::exists(stem + ".color.jpg")) continue;
    PosedFrame frame{FeaturesOf(ReadAll(stem + ".color.jpg")),
                     perception::DecodeDepth(ReadAll(stem + ".depth.png")).value()};
    std::ifstream pose(stem + ".pose.txt");
    for (int k = 0; k < 16; ++k) pose >> frame.T_world_camera(k / 4, k % 4);
    frames.push_back(std::move(frame));
  }
  if (frames.empty()) return nullptr;
  std::map<std::string, Share> shares;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (std::size_t j = i + 1; j < frames.size(); ++j) {
      const double overlap = std::min(Overlap(frames[i], frames[j]), Overlap(frames[j], frames[i]));
      const char* kind = overlap > 0.5    ? "above 0.5"
                         : overlap > 0.3  ? "0.3 to 0.5"
                         : overlap > 0.1  ? "0.1 to 0.3"
                         : overlap > 0.02 ? "0.02 to 0.1"
                                          : "below 0.02";
      bool accepted = false;
      Inliers(frames[i].features, frames[j].features, accepted);
      shares[kind].Add(accepted);
    }
  }
  nlohmann::json document;
  for (const auto& [kind, share] : shares) document[kind] = share.json();
  return document;
}

}  // namespace enfilade::bench

// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/policies.h"

#include <gtest/gtest.h>

namespace enfilade::slam {
namespace {

LocalMatch Match(double matched, double contradicted, bool good) {
  LocalMatch match;
  match.agreement = {matched, contradicted};
  match.good = good;
  return match;
}

TEST(KeyframePolicy, TakesScansFarEnoughInPlaceOrAngle) {
  const KeyframeOptions options{.distance = 0.3, .angle = 0.26};
  EXPECT_FALSE(IsKeyframeDue({0.2, 0.2, 0.1}, options));
  EXPECT_TRUE(IsKeyframeDue({0.22, 0.22, 0.0}, options));
  EXPECT_TRUE(IsKeyframeDue({0.0, 0.0, -0.27}, options));
}

TEST(SubmapPolicy, CountsOwnKeyframesOnlyAndHoldsTheBounds) {
  Submap submap{0, 0, {}, {{}, {}, {}, SubmapGrid(0.05, {})}};
  submap.content.nodes.resize(12);
  for (int i = 0; i < 10; ++i) submap.content.nodes[static_cast<std::size_t>(i)].carried = true;
  EXPECT_FALSE(IsSubmapFull(submap, {}, {.max_keyframes = 3, .max_extent = 5.0}));
  EXPECT_TRUE(IsSubmapFull(submap, {}, {.max_keyframes = 2, .max_extent = 5.0}));
  EXPECT_TRUE(IsSubmapFull(submap, {4.0, 4.0, 0.0}, {.max_keyframes = 3, .max_extent = 5.0}));
}

TEST(TrackQuality, IsLostAfterPoorScansInARowAndElsewhereAfterContradictions) {
  const LocalMatchOptions local;
  const QualityOptions options{.lost_after = 2, .new_submap_after = 3};
  TrackQuality quality;
  for (int i = 0; i < 2; ++i) quality = Updated(quality, Match(0.05, 0.0, false), local);  // sees too little
  EXPECT_TRUE(IsLost(quality, options));
  for (int i = 0; i < 10; ++i) quality = Updated(quality, Match(0.05, 0.0, false), local);
  EXPECT_FALSE(IsElsewhere(quality, options)) << "nothing was contradicted";
  for (int i = 0; i < 3; ++i) quality = Updated(quality, Match(0.2, 0.6, false), local);
  EXPECT_TRUE(IsElsewhere(quality, options));
  quality = Updated(quality, Match(0.8, 0.1, true), local);
  EXPECT_FALSE(IsLost(quality, options));
  EXPECT_FALSE(IsElsewhere(quality, options));
}

TEST(SolvePolicy, WaitsForAShareOfGrowthAndForLessOfItWhenUrgent) {
  const GraphOptions options{.growth = 0.10, .urgent_growth = 0.02};
  EXPECT_TRUE(IsSolveDue(1, 0, false, options));
  EXPECT_FALSE(IsSolveDue(1'050, 1'000, false, options));
  EXPECT_TRUE(IsSolveDue(1'100, 1'000, false, options));
  EXPECT_FALSE(IsSolveDue(1'010, 1'000, true, options));
  EXPECT_TRUE(IsSolveDue(1'020, 1'000, true, options));
}

TEST(InsertPolicy, KeepsContradictingScansOutOfTheMap) {
  const LocalMatchOptions local;
  EXPECT_TRUE(MayInsert(Match(0.8, 0.1, true), local));
  EXPECT_TRUE(MayInsert(Match(0.1, 0.05, false), local)) << "new ground";
  EXPECT_FALSE(MayInsert(Match(0.2, 0.6, false), local));
}

}  // namespace
}  // namespace enfilade::slam

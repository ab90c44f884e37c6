// SPDX-License-Identifier: Apache-2.0
#include "perception/image/match_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "perception/image/decode.h"
#include "perception/image/draw_matches.h"
#include "perception/image/match_series.h"
#include "tests/support/corridor.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/perception/image/scenes.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

FeatureSet FeaturesOf(const cv::Mat& grey) { return ExtractFeatures(testing::ToFrame(grey)).value(); }

ImageMatch Match(const cv::Mat& a, const cv::Mat& b, const ImageMatchOptions& options = {}) {
  return MatchImages(FeaturesOf(a), FeaturesOf(b), options).value();
}

TEST(MatchImagesTest, KnowsAPlaceFromTheSide) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const cv::Mat place = testing::Place(seed);
    const ImageMatch match = Match(place, testing::SeenAgain(place, seed + 10));
    EXPECT_TRUE(match.accepted) << match.reason;
    EXPECT_GT(match.inliers, 100);
  }
}

TEST(MatchImagesTest, DistinguishesPlaces) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const ImageMatch match = Match(testing::Place(seed), testing::Place(seed + 100));
    EXPECT_FALSE(match.accepted) << match.reason;
  }
}

TEST(MatchImagesTest, KnowsARotatedImage) {
  const cv::Mat place = testing::Place(3, {400, 400});
  cv::Mat rotated;
  for (const auto turn : {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE}) {
    cv::rotate(place, rotated, turn);
    const ImageMatch match = Match(place, rotated);
    EXPECT_TRUE(match.accepted) << match.reason;
    EXPECT_GT(match.inliers, match.matches * 9 / 10);
  }
}

// Many spots have their like elsewhere in a mirror image, but no geometry joins them.
TEST(MatchImagesTest, DoesNotTakeAMirrorImageForThePlace) {
  const cv::Mat place = testing::Place(4);
  cv::Mat mirrored;
  cv::flip(place, mirrored, 1);
  EXPECT_FALSE(Match(place, mirrored).accepted);
}

// Tiles and doors alike; nothing else, or other things beside each door.
TEST(MatchImagesTest, RejectsDifferentDoorsInTheSameTexture) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const cv::Mat door = testing::DoorInTiles(seed, 60);
    const ImageMatch other = Match(door, testing::SeenAgain(testing::DoorInTiles(seed + 50, 60), seed));
    EXPECT_FALSE(other.accepted) << seed << ": " << other.reason;
    const ImageMatch same = Match(door, testing::SeenAgain(door, seed));
    EXPECT_TRUE(same.accepted) << seed << ": " << same.reason;
  }
}

TEST(MatchImagesTest, ReportsImagesWithoutTexture) {
  const FeatureSet place = FeaturesOf(testing::Place(1));
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(31, 31), cv::Size(33, 33), cv::Size(3000, 2), cv::Size(512, 384)}) {
    const FeatureSet black = FeaturesOf(cv::Mat(size, CV_8U, cv::Scalar(0)));
    ASSERT_OK_AND_ASSIGN(const ImageMatch match, MatchImages(place, black));
    EXPECT_FALSE(match.accepted);
    EXPECT_THAT(match.reason, HasSubstr("image B has too little texture: 0 features"));
    ASSERT_OK_AND_ASSIGN(const ImageMatch both, MatchImages(black, black));
    EXPECT_FALSE(both.accepted);
  }
}

TEST(MatchImagesTest, DoesNotDependOnTheNumberOfThreads) {
  const cv::Mat place = testing::Place(6);
  const cv::Mat again = testing::SeenAgain(place, 7);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const FeatureSet alone = FeaturesOf(place);
  const ImageMatch first = Match(place, again);
  for (const int others : {2, 4, 7}) {
    cv::setNumThreads(others);
    cv::theRNG().state = static_cast<std::uint64_t>(others);
    EXPECT_EQ(FeaturesOf(place), alone);
    const ImageMatch match = Match(place, again);
    EXPECT_EQ(match.inliers, first.inliers);
    ASSERT_EQ(match.pairs.size(), first.pairs.size());
    for (std::size_t i = 0; i < match.pairs.size(); ++i) {
      EXPECT_EQ(match.pairs[i].a, first.pairs[i].a);
      EXPECT_EQ(match.pairs[i].is_inlier, first.pairs[i].is_inlier);
    }
  }
  cv::setNumThreads(threads);
}

TEST(MatchImagesTest, VerifiesByEpipolarGeometryToo) {
  const cv::Mat place = testing::Place(8);
  const cv::Mat again = testing::SeenAgain(place, 9);
  const Intrinsics camera{.fx = 450.0, .fy = 450.0, .cx = 256.0, .cy = 192.0};
  for (const GeometricModel model : {GeometricModel::kNone, GeometricModel::kFundamental, GeometricModel::kEssential}) {
    ImageMatchOptions options;
    options.model = model;
    options.intrinsics_a = camera;
    options.intrinsics_b = camera;
    EXPECT_TRUE(Match(place, again, options).accepted);
  }
  ImageMatchOptions blind;
  blind.model = GeometricModel::kEssential;
  EXPECT_STATUS(MatchImages(FeaturesOf(place), FeaturesOf(again), blind), absl::StatusCode::kInvalidArgument,
                HasSubstr("intrinsics"));
}

TEST(MatchImagesTest, FindsThePlaceInAnImageOfAnotherSize) {
  const cv::Mat place = testing::Place(11, {1280, 960});
  cv::Mat small;
  cv::resize(testing::SeenAgain(place, 12), small, {512, 384}, 0, 0, cv::INTER_AREA);
  const ImageMatch match = Match(place, small);
  ASSERT_TRUE(match.accepted) << match.reason;
  for (const PointPair& pair : match.pairs) {
    if (!pair.is_inlier) continue;
    EXPECT_LT((pair.a * 0.4F - pair.b).norm(), 60.0F);  // SeenAgain's 40 pixels and more
  }
}

// Along a corridor, what is far ahead looks the same from places metres apart: 15 of these 24 pairs have inliers
// enough.
TEST(MatchImagesTest, KnowsThatAViewFromFartherAlongACorridorIsOfAnotherPlace) {
  int recalled = 0;
  int told = 0;
  int mistaken = 0;
  constexpr int kCorridors = 8;
  for (std::uint64_t i = 0; i < kCorridors; ++i) {
    const enfilade::testing::Corridor corridor(301000 + 1000 * i);
    const auto same = enfilade::testing::SeeSamePlaceTwice(corridor, i);
    recalled += MatchImages(same.a, same.b).value().accepted ? 1 : 0;
    for (const double ahead : {3.0, 4.0, 6.0}) {
      const auto other = enfilade::testing::SeeFromAhead(corridor, ahead, 50 + i);
      const ImageMatch match = MatchImages(other.a, other.b).value();
      EXPECT_EQ(MatchImages(other.b, other.a).value().accepted, match.accepted) << "corridor " << i << ", " << ahead;
      mistaken += match.accepted ? 1 : 0;
      if (match.reason.starts_with("same view, other place")) ++told;
      EXPECT_EQ(match.other_place, match.reason.starts_with("same view, other place")) << match.reason;
    }
  }
  EXPECT_EQ(recalled, kCorridors);
  EXPECT_EQ(mistaken, 0);
  EXPECT_GE(told, 12);
}

TEST(MatchImagesTest, CountsAllMatchesAsMapManagerDoes) {
  const cv::Mat door = testing::DoorInTiles(10, 60);
  const ImageMatch match =
      Match(door, testing::SeenAgain(testing::DoorInTiles(60, 60), 10), MapManagerImageMatchOptions());
  EXPECT_EQ(match.inliers, match.matches);
  EXPECT_EQ(match.accepted, match.matches > 30);
}

TEST(MatchSeriesTest, SaysThatTheViewIsTheSameFromAnotherPlace) {
  const enfilade::testing::Corridor corridor(302000);
  const auto other = enfilade::testing::SeeFromAhead(corridor, 3.0, 51);
  ASSERT_TRUE(MatchImages(other.a, other.b).value().other_place);
  const std::vector<Views> series(3, Views{.front = &other.b, .rear = nullptr});
  ASSERT_OK_AND_ASSIGN(const SeriesMatch match, MatchSeries({.front = &other.a}, series));
  EXPECT_FALSE(match.accepted);
  EXPECT_TRUE(match.other_place);
  EXPECT_THAT(match.reason, HasSubstr("same view, other place"));
}

TEST(MatchImagesTest, NamesOptionsOutOfRange) {
  const FeatureSet place = FeaturesOf(testing::Place(1));
  ImageMatchOptions options;
  options.ratios.sift = 1.5;
  EXPECT_STATUS(MatchImages(place, place, options), absl::StatusCode::kInvalidArgument, HasSubstr("1.5"));
  FeatureSet broken = place;
  broken.sift_descriptors.pop_back();
  EXPECT_STATUS(MatchImages(place, broken), absl::StatusCode::kInvalidArgument, HasSubstr("image B"));
}

class SeriesTest : public ::testing::Test {
 protected:
  cv::Mat front_ = testing::Place(21);
  cv::Mat rear_ = testing::Place(22);
  FeatureSet stored_front_ = FeaturesOf(front_);
  FeatureSet stored_rear_ = FeaturesOf(rear_);
  FeatureSet nothing_ = FeaturesOf(testing::Place(99));

  static std::vector<FeatureSet> Again(const cv::Mat& place, std::uint32_t seed) {
    std::vector<FeatureSet> series;
    for (std::uint32_t k = 0; k < 6; ++k) series.push_back(FeaturesOf(testing::SeenAgain(place, seed + k)));
    return series;
  }
};

// A candidate keeps its rear image; the robot that comes back sees the same with its front camera.
TEST_F(SeriesTest, ComparesACandidatesRearImageWithFrontImages) {
  const std::vector<FeatureSet> now = Again(rear_, 30);
  std::vector<Views> series;
  for (const FeatureSet& image : now) series.push_back({.front = &image});
  ASSERT_OK_AND_ASSIGN(const SeriesMatch match, MatchSeries({.rear = &stored_rear_}, series));
  EXPECT_TRUE(match.accepted);
  EXPECT_EQ(match.heading, Heading::kOpposite);
  EXPECT_EQ(match.scores.size(), 6U);
}

TEST_F(SeriesTest, FindsTheHeading) {
  const std::vector<FeatureSet> front = Again(front_, 40);
  const std::vector<FeatureSet> rear = Again(rear_, 50);
  std::vector<Views> same;
  std::vector<Views> opposite;
  for (std::size_t k = 0; k < front.size(); ++k) {
    same.push_back({.front = &front[k], .rear = &rear[k]});
    opposite.push_back({.front = &rear[k], .rear = &front[k]});
  }
  const Views stored{.front = &stored_front_, .rear = &stored_rear_};
  ASSERT_OK_AND_ASSIGN(const SeriesMatch as_before, MatchSeries(stored, same));
  ASSERT_OK_AND_ASSIGN(const SeriesMatch turned, MatchSeries(stored, opposite));
  EXPECT_EQ(as_before.heading, Heading::kSame);
  EXPECT_EQ(turned.heading, Heading::kOpposite);
  EXPECT_TRUE(as_before.accepted);
  EXPECT_TRUE(turned.accepted);
  EXPECT_EQ(as_before.other_score, 0);
}

TEST_F(SeriesTest, TakesTheMedianSoThatHalfTheMomentsMustAgree) {
  const std::vector<FeatureSet> now = Again(front_, 60);
  const auto with_good = [&](std::size_t good) {
    std::vector<Views> series;
    for (std::size_t k = 0; k < now.size(); ++k) series.push_back({.front = k < good ? &now[k] : &nothing_});
    return MatchSeries({.front = &stored_front_}, series).value();
  };
  EXPECT_FALSE(with_good(2).accepted);
  EXPECT_TRUE(with_good(4).accepted);
  const SeriesMatch half = with_good(3);  // the mean of 0 and the third best
  EXPECT_EQ(half.score, *std::min_element(half.scores.begin(), half.scores.begin() + 3) / 2);
}

TEST_F(SeriesTest, RefusesAnEmptySeries) {
  EXPECT_STATUS(MatchSeries({.front = &stored_front_}, {}), absl::StatusCode::kInvalidArgument, HasSubstr("empty"));
  const std::vector<Views> series(6);
  EXPECT_STATUS(MatchSeries({}, series), absl::StatusCode::kInvalidArgument, HasSubstr("stored"));
  ASSERT_OK_AND_ASSIGN(const SeriesMatch unseen, MatchSeries({.front = &stored_front_}, series));
  EXPECT_FALSE(unseen.accepted);
}

TEST(MatchPictureTest, PutsTheImagesSideBySide) {
  const cv::Mat place = testing::Place(1);
  const cv::Mat again = testing::SeenAgain(place, 2);
  ASSERT_OK_AND_ASSIGN(const grid::RgbImage picture,
                       DrawMatches(testing::ToFrame(place), testing::ToFrame(again), Match(place, again)));
  EXPECT_EQ(picture.width, 512 + 8 + 512);
  EXPECT_EQ(picture.height, 384);
  ASSERT_OK_AND_ASSIGN(const grid::RgbImage tiny,
                       DrawMatches({1, 1, {0}}, testing::ToFrame(testing::Place(1, {4000, 1000})), {}));
  EXPECT_LE(tiny.width, 1280);
}

absl::StatusOr<FeatureSet> Load(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  auto frame = DecodeGrey(std::move(bytes).str());
  if (!frame.ok()) return frame.status();
  return ExtractFeatures(*frame);
}

// Two drives through one corridor: image i shows the place of image i + 40. Two of the twenty show nothing but a wall.
TEST(MatchImagesTest, KnowsTheCorridorOfARecordingAgainAndMistakesNoPlace) {
  ENFILADE_RECORDING_OR_SKIP(folder, "images/rtabmap_samples");
  std::vector<std::pair<int, FeatureSet>> images;
  for (int i = 1; i <= 60; ++i) {
    if (i > 20 && i <= 40) continue;
    ASSERT_OK_AND_ASSIGN(FeatureSet features, Load(folder / (std::to_string(i) + ".jpg")));
    images.emplace_back(i, std::move(features));
  }
  int recalled = 0;
  for (std::size_t x = 0; x < images.size(); ++x) {
    for (std::size_t y = x + 1; y < images.size(); ++y) {
      const int i = images[x].first;
      const int j = images[y].first;
      const bool is_same = j - i == 40;
      if (!is_same && std::abs(i % 40 - j % 40) < 4) continue;
      ASSERT_OK_AND_ASSIGN(const ImageMatch match, MatchImages(images[x].second, images[y].second));
      if (is_same && match.accepted) ++recalled;
      EXPECT_TRUE(is_same || !match.accepted) << i << " and " << j << ": " << match.reason;
    }
  }
  EXPECT_GE(recalled, 18);
}

}  // namespace
}  // namespace enfilade::perception

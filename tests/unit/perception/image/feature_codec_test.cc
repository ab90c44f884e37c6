// SPDX-License-Identifier: Apache-2.0
#include "perception/image/feature_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"
#include "tests/unit/perception/image/scenes.h"

namespace enfilade::perception {
namespace {

class FeatureCodecTest : public ::testing::Test {
 protected:
  FeatureSet features_ = ExtractFeatures(testing::ToFrame(testing::Place(5))).value();
  std::string bytes_ = EncodeFeatures(features_);
};

TEST_F(FeatureCodecTest, RestoresFeatures) {
  ASSERT_FALSE(features_.sift.empty());
  ASSERT_FALSE(features_.akaze.empty());
  ASSERT_OK_AND_ASSIGN(const FeatureSet decoded, DecodeFeatures(bytes_));
  EXPECT_EQ(decoded, features_);
}

TEST_F(FeatureCodecTest, KeepsAnImageWithoutFeatures) {
  FeatureSet none;
  none.width = 1;
  none.height = 1;
  ASSERT_OK_AND_ASSIGN(const FeatureSet decoded, DecodeFeatures(EncodeFeatures(none)));
  EXPECT_EQ(decoded, none);
}

TEST_F(FeatureCodecTest, RefusesEveryCut) {
  for (std::size_t size = 0; size < bytes_.size(); size += size < 64 ? 1 : 97) {
    EXPECT_CODE(DecodeFeatures(std::string_view(bytes_).substr(0, size)), absl::StatusCode::kDataLoss) << size;
  }
  EXPECT_CODE(DecodeFeatures(bytes_ + "x"), absl::StatusCode::kDataLoss);
}

TEST_F(FeatureCodecTest, RefusesAnotherVersion) {
  bytes_[0] = 2;
  EXPECT_STATUS(DecodeFeatures(bytes_), absl::StatusCode::kDataLoss, ::testing::HasSubstr("version 2"));
}

// The count of keypoints says more than any memory holds.
TEST_F(FeatureCodecTest, RefusesImpossibleCounts) {
  for (std::size_t i = 9; i < 17; ++i) bytes_[i] = '\x7f';
  EXPECT_CODE(DecodeFeatures(bytes_), absl::StatusCode::kDataLoss);
}

TEST_F(FeatureCodecTest, RefusesKeypointsThatAreNotFinite) {
  for (std::size_t i = 17; i < 21; ++i) bytes_[i] = '\xff';  // the first x is NaN
  EXPECT_CODE(DecodeFeatures(bytes_), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::perception

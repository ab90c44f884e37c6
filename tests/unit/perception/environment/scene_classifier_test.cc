// SPDX-License-Identifier: Apache-2.0
#include "perception/environment/scene_classifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/base/environment.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/perception/environment/onnx_writer.h"

namespace enfilade::perception {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const char* const kLabels = "/o/office 0\n/s/sky 1\n/f/field 2\n";
const char* const kMapping = "# 1 indoor, 2 outdoor\n/s/sky 2\n/f/field outdoor\n/o/office 1\n";

// Red is an office, blue the sky, green a field.
std::string ColorModel() { return testing::MeanColorModel({1, 0, 0, 0, 0, 1, 0, 1, 0}, {0.0F, 0.0F, 0.0F}, 224); }

ColorFrame OneColor(int width, int height, std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  ColorFrame frame{width, height, {}};
  for (int i = 0; i < width * height; ++i) frame.samples.insert(frame.samples.end(), {red, green, blue});
  return frame;
}

std::vector<SceneClass> Classes() { return ParseSceneClasses(kLabels, kMapping).value(); }

TEST(SceneClassifierTest, RunsAnOnnxNetworkOnTheImagesColors) {
  ASSERT_OK_AND_ASSIGN(SceneClassifier classifier, SceneClassifier::Make(ColorModel(), Classes()));
  ASSERT_OK_AND_ASSIGN(const SceneVerdict office, classifier.Classify(OneColor(640, 480, 255, 0, 0)));
  EXPECT_EQ(office.environment, Environment::kIndoor);
  EXPECT_EQ(office.best_class, "/o/office");
  ASSERT_OK_AND_ASSIGN(const SceneVerdict sky, classifier.Classify(OneColor(50, 400, 0, 0, 255)));
  EXPECT_EQ(sky.environment, Environment::kOutdoor);
  EXPECT_EQ(sky.best_class, "/s/sky");
}

// The scores are (value - mean) / deviation of the channels; softmax of them.
TEST(SceneClassifierTest, NormalisesAsPlaces365Does) {
  ASSERT_OK_AND_ASSIGN(SceneClassifier classifier, SceneClassifier::Make(ColorModel(), Classes()));
  ASSERT_OK_AND_ASSIGN(const SceneVerdict verdict, classifier.Classify(OneColor(300, 300, 255, 51, 102)));
  const double red = std::exp((1.0 - 0.485) / 0.229);
  const double green = std::exp((0.2 - 0.456) / 0.224);
  const double blue = std::exp((0.4 - 0.406) / 0.225);
  EXPECT_NEAR(verdict.best_probability, red / (red + green + blue), 1e-3);
  EXPECT_NEAR(verdict.outdoor_probability, (green + blue) / (red + green + blue), 1e-3);
}

TEST(SceneClassifierTest, LoadsItsFilesAndNamesTheOneThatIsMissing) {
  const enfilade::testing::TemporaryDirectory directory;
  const SceneClassifierFiles files{.model = directory.path() / "places.onnx",
                                   .labels = directory.path() / "labels.txt",
                                   .mapping = directory.path() / "mapping.txt"};
  EXPECT_STATUS(SceneClassifier::Load(files), absl::StatusCode::kNotFound,
                AllOf(HasSubstr("places.onnx"), HasSubstr("does not exist")));
  EXPECT_STATUS(SceneClassifier::Load({}), absl::StatusCode::kNotFound, HasSubstr("model"));
  std::ofstream(files.model, std::ios::binary) << ColorModel();
  EXPECT_STATUS(SceneClassifier::Load(files), absl::StatusCode::kNotFound, HasSubstr("labels.txt"));
  std::ofstream(files.labels) << kLabels;
  std::ofstream(files.mapping) << kMapping;
  EXPECT_OK(SceneClassifier::Load(files));
}

TEST(SceneClassifierTest, RefusesAModelOfAnotherShape) {
  const auto make = [](const std::string& onnx) { return SceneClassifier::Make(onnx, Classes()); };
  const std::string two_classes = testing::MeanColorModel({1, 0, 0, 0, 0, 1}, {0.0F, 0.0F}, 224);
  EXPECT_STATUS(make(two_classes), absl::StatusCode::kInvalidArgument, HasSubstr("2 outputs for 3 labels"));
  const std::string one_channel = testing::MeanColorModel({1, 0, 0}, {0.0F, 0.0F, 0.0F}, 224, 1);
  EXPECT_CODE(make(one_channel), absl::StatusCode::kInvalidArgument);
}

TEST(SceneClassifierTest, RefusesBytesThatAreNoModel) {
  const std::string model = ColorModel();
  for (const std::string& onnx : {std::string(), std::string("not a network"), model.substr(0, model.size() / 2)}) {
    EXPECT_CODE(SceneClassifier::Make(onnx, Classes()), absl::StatusCode::kInvalidArgument) << onnx.size();
  }
  ASSERT_OK_AND_ASSIGN(SceneClassifier classifier, SceneClassifier::Make(model, Classes()));
  EXPECT_CODE(classifier.Classify({2, 2, {0}}), absl::StatusCode::kInvalidArgument);
}

TEST(SceneClassesTest, NamesTheLineThatIsWrong) {
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(ParseSceneClasses("", kMapping), kBad, HasSubstr("no class"));
  EXPECT_STATUS(ParseSceneClasses("/o/office\n/x/unknown\n", kMapping), kBad,
                HasSubstr("line 2: the class /x/unknown is not in"));
  EXPECT_STATUS(ParseSceneClasses("/o/office\n/o/office\n", kMapping), kBad, HasSubstr("duplicate class"));
  EXPECT_STATUS(ParseSceneClasses(kLabels, "/o/office 3\n"), kBad, HasSubstr("line 1"));
  EXPECT_STATUS(ParseSceneClasses(kLabels, "/o/office 1\n/o/office 2\n"), kBad, HasSubstr("mapping, line 2"));
}

}  // namespace
}  // namespace enfilade::perception

// SPDX-License-Identifier: Apache-2.0
#include "core/closure/closure_options.h"

#include <set>

#include "gmock/gmock.h"
#include "tests/support/status_assertions.h"

namespace enfilade::closure {
namespace {

using ::testing::HasSubstr;

TEST(DoorClosureOptions, DefaultsAreValidAndEveryNameComesOnce) {
  EXPECT_OK(DoorClosureOptions().Validate());
  std::set<std::string> names;
  const DoorClosureOptions options;
  VisitDoorClosureOptions(options,
                          [&](const char* name, const auto&) { EXPECT_TRUE(names.insert(name).second) << name; });
  EXPECT_GT(names.size(), 30U);
}

TEST(DoorClosureOptions, AreReadFromYamlOnTopOfABase) {
  DoorClosureOptions base;
  base.known_across = 0.7;
  ASSERT_OK_AND_ASSIGN(const DoorClosureOptions options,
                       ParseDoorClosureOptions("image_threshold: 22\nmap_name: Raum\nplace_sigma: 0.3\n", base));
  EXPECT_EQ(options.image_threshold, 22);
  EXPECT_EQ(options.map_name, "Raum");
  EXPECT_EQ(options.place_sigma, 0.3);
  EXPECT_EQ(options.known_across, 0.7);
}

TEST(DoorClosureOptions, RefusesWhatIsNoneNamingIt) {
  const auto parse = [](const char* yaml) { return ParseDoorClosureOptions(yaml, DoorClosureOptions()).status(); };
  EXPECT_STATUS(parse("image_treshold: 3\n"), absl::StatusCode::kInvalidArgument,
                HasSubstr("line 1: there is no option image_treshold"));
  EXPECT_STATUS(parse("\nmax_compared: many\n"), absl::StatusCode::kInvalidArgument, HasSubstr("line 2"));
  EXPECT_STATUS(parse("gate_probability: 1\n"), absl::StatusCode::kInvalidArgument, HasSubstr("gate_probability"));
  EXPECT_STATUS(parse("known_across: -1\n"), absl::StatusCode::kInvalidArgument, HasSubstr("known_across"));
  EXPECT_STATUS(parse("place_sigma: 0\n"), absl::StatusCode::kInvalidArgument, HasSubstr("sigma"));
  EXPECT_STATUS(parse("min_inlier_share: 1.5\n"), absl::StatusCode::kInvalidArgument, HasSubstr("share"));
  EXPECT_STATUS(parse("image_sift_ratio: 0\n"), absl::StatusCode::kInvalidArgument, HasSubstr("image_sift_ratio"));
  EXPECT_STATUS(parse("image_akaze_ratio: 1.1\n"), absl::StatusCode::kInvalidArgument, HasSubstr("image_akaze_ratio"));
  EXPECT_STATUS(parse("image_tolerance: 0.5\n"), absl::StatusCode::kInvalidArgument, HasSubstr("image_tolerance"));
  EXPECT_STATUS(parse("images_now: 0\n"), absl::StatusCode::kInvalidArgument, HasSubstr("images_now"));
  EXPECT_STATUS(parse("map_name: ''\n"), absl::StatusCode::kInvalidArgument, HasSubstr("map_name"));
}

}  // namespace
}  // namespace enfilade::closure

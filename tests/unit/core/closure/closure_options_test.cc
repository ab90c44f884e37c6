// SPDX-License-Identifier: Apache-2.0
#include "core/closure/closure_options.h"

#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

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

TEST(DoorClosureOptions, ValidateNamesTheOptionThatIsOutOfRange) {
  using Change = std::function<void(DoorClosureOptions&)>;
  const std::vector<std::pair<const char*, Change>> cases = {
      {"gate_probability", [](DoorClosureOptions& o) { o.gate_probability = 1.0; }},
      {"strict_probability", [](DoorClosureOptions& o) { o.strict_probability = 0.0; }},
      {"known_across is -1", [](DoorClosureOptions& o) { o.known_across = -1.0; }},
      {"search_base is nan", [](DoorClosureOptions& o) { o.search_base = NAN; }},
      {"patience is inf", [](DoorClosureOptions& o) { o.patience = INFINITY; }},
      {"max_compared is -1", [](DoorClosureOptions& o) { o.max_compared = -1; }},
      {"max_searched is -1", [](DoorClosureOptions& o) { o.max_searched = -1; }},
      {"sigmas", [](DoorClosureOptions& o) { o.place_sigma = 0.0; }},
      {"sigmas", [](DoorClosureOptions& o) { o.origin_yaw_sigma = 0.0; }},
      {"sigmas", [](DoorClosureOptions& o) { o.ride_yaw_sigma = 0.0; }},
      {"cloud_voxel", [](DoorClosureOptions& o) { o.cloud_voxel = 0.0; }},
      {"share", [](DoorClosureOptions& o) { o.min_inlier_share = 1.5; }},
      {"share", [](DoorClosureOptions& o) { o.locate_min_share = 1.01; }},
      {"image_sift_ratio", [](DoorClosureOptions& o) { o.image_sift_ratio = 0.0; }},
      {"image_akaze_ratio", [](DoorClosureOptions& o) { o.image_akaze_ratio = 1.1; }},
      {"image_tolerance", [](DoorClosureOptions& o) { o.image_tolerance = 0.5; }},
      {"images_now", [](DoorClosureOptions& o) { o.images_now = 0; }},
      {"images_kept", [](DoorClosureOptions& o) { o.images_kept = 101; }},
      {"locate_scans", [](DoorClosureOptions& o) { o.locate_scans = 0; }},
      {"map_name", [](DoorClosureOptions& o) { o.map_name.clear(); }},
      {"map_name", [](DoorClosureOptions& o) { o.map_name = std::string(101, 'x'); }},
  };
  for (const auto& [name, change] : cases) {
    DoorClosureOptions options;
    change(options);
    EXPECT_STATUS(options.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr(name));
  }
}

TEST(DoorClosureOptions, ExtremesThatMakeSenseAreValid) {
  DoorClosureOptions options;
  options.min_inlier_share = 1.0;
  options.image_sift_ratio = 1.0;
  options.max_compared = 0;  // scans only
  options.patience = 0.0;    // waits for nobody
  options.images_now = 100;
  options.map_name = std::string(100, 'x');
  EXPECT_OK(options.Validate());
}

// The server's configuration is read by these names, whatever the type of the option.
TEST(DoorClosureOptions, VisitReachesEveryOptionForWriting) {
  DoorClosureOptions options;
  VisitDoorClosureOptions(options, [](const char* /*name*/, auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::string>) {
      value += "x";
    } else {
      value = value / Value{2};
    }
  });
  const DoorClosureOptions defaults;
  EXPECT_EQ(options.gate_probability, defaults.gate_probability / 2);
  EXPECT_EQ(options.latch_distance, defaults.latch_distance / 2);
  EXPECT_EQ(options.sure_radius, defaults.sure_radius / 2);
  EXPECT_EQ(options.locate_scans, defaults.locate_scans / 2);
  EXPECT_EQ(options.map_name, defaults.map_name + "x");
  EXPECT_EQ(options.outdoor_profile, "x");
}

}  // namespace
}  // namespace enfilade::closure

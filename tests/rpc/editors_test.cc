// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cstdlib>
#include <map>
#include <random>
#include <thread>

#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "fmt/format.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using Stub = v1::LinkPointService::Stub;

// Two editors change the same few link points and maps while ten robots add, find and report, for three seconds, or as
// many as ENFILADE_EDITORS_SECONDS says.
class EditorsTest : public ServerTest {
 protected:
  static constexpr int kShared = 3;

  static double Seconds() {
    const char* seconds = std::getenv("ENFILADE_EDITORS_SECONDS");
    return seconds ? std::atof(seconds) : 3.0;
  }
  v1::CreateLinkPointRequest NewLinkPoint(const std::string& id, double x) const {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/s");
    request.set_link_point_id(id);
    v1::Anchor& anchor = *request.mutable_link_point()->add_anchors();
    anchor.set_map("sites/s/maps/m");
    anchor.mutable_pose_map_place()->mutable_pose()->set_x(x);
    return request;
  }
  // Reads, adds one to the difficulty, writes under the etag. ABORTED where another was faster.
  absl::Status AddOne(int shared) const {
    v1::GetLinkPointRequest get;
    get.set_name(fmt::format("sites/s/linkPoints/shared{}", shared));
    ENFILADE_ASSIGN_OR_RETURN(const auto read, Call(&Stub::GetLinkPoint, get));
    v1::UpdateLinkPointRequest update;
    *update.mutable_link_point() = read.link_point();
    update.mutable_link_point()->set_difficulty(read.link_point().difficulty() + 1);
    update.mutable_update_mask()->add_paths("difficulty");
    return Call(&Stub::UpdateLinkPoint, update).status();
  }
};

TEST_F(EditorsTest, LoseNoUpdateAndNeverWaitForOneAnother) {
  for (int i = 0; i < kShared; ++i) {
    ASSERT_OK(Call(&Stub::CreateLinkPoint, NewLinkPoint(fmt::format("shared{}", i), 10.0 * i)));
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(Seconds());
  std::atomic<int> written[kShared] = {};
  std::atomic<int> stale{0}, created{0}, removed{0};
  std::vector<std::thread> threads;
  for (int editor = 0; editor < 2; ++editor) {
    threads.emplace_back([&, editor] {
      std::mt19937 random(static_cast<unsigned>(editor));
      while (std::chrono::steady_clock::now() < end) {
        const int shared = static_cast<int>(random() % kShared);
        const absl::Status status = AddOne(shared);
        if (status.ok()) ++written[shared];
        if (absl::IsAborted(status)) {
          EXPECT_EQ(status.message().find("deadlock"), std::string::npos) << status;
          ++stale;
        } else {
          EXPECT_OK(status);
        }
        v1::UpdateMapRequest map;
        map.mutable_map()->set_name("sites/s/maps/m");
        map.mutable_map()->set_level(static_cast<int>(random() % 3));
        map.mutable_update_mask()->add_paths("level");
        const absl::Status updated = Call(&v1::MapService::Stub::UpdateMap, map).status();
        if (!absl::IsAborted(updated)) {
          EXPECT_OK(updated);
        }
      }
    });
  }
  for (int robot = 0; robot < 10; ++robot) {
    threads.emplace_back([&, robot] {
      for (int i = 0; std::chrono::steady_clock::now() < end; ++i) {
        const std::string id = fmt::format("r{}-{}", robot, i);
        EXPECT_OK(Call(&Stub::CreateLinkPoint, NewLinkPoint(id, 100.0 + robot)));
        ++created;
        v1::FindLinkPointsRequest find;
        find.set_parent("sites/s");
        find.mutable_point_world()->set_x(100.0);
        find.set_radius_m(50.0);
        EXPECT_OK(Call(&Stub::FindLinkPoints, find));
        if (i % 2 == 0) continue;
        v1::DeleteLinkPointRequest remove;
        remove.set_name("sites/s/linkPoints/" + id);
        EXPECT_OK(Call(&Stub::DeleteLinkPoint, remove));
        ++removed;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  int updates = 0;
  for (int i = 0; i < kShared; ++i) {
    v1::GetLinkPointRequest get;
    get.set_name(fmt::format("sites/s/linkPoints/shared{}", i));
    ASSERT_OK_AND_ASSIGN(const auto read, Call(&Stub::GetLinkPoint, get));
    EXPECT_EQ(read.link_point().difficulty(), written[i].load()) << "an update was lost";
    updates += written[i];
  }
  EXPECT_GT(updates, 0);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.link_points"),
            std::to_string(kShared + created - removed));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) = max(version) FROM enfilade.graph_versions"), "t");
  EXPECT_EQ(database_.SqlValue("SELECT deadlocks FROM pg_stat_database WHERE datname = current_database()"), "0");
  RecordProperty("updates", updates);
  RecordProperty("stale", stale.load());
  RecordProperty("created", created.load());
  std::cout << updates << " updates, " << stale << " stale, " << created << " created, " << removed << " removed\n";
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
// What people have edited goes with maps that are merged.
#include <algorithm>
#include <map>

#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "tests/rpc/rearrange_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class RearrangedEditsTest : public RearrangeTest {
 protected:
  // A draft of a map. Gives its name.
  std::string Draw(const std::string& map, const std::string& id, const std::vector<v1::MapEdit>& edits) {
    v1::CreateMapDraftRequest create;
    create.set_parent("sites/s/maps/" + map);
    create.set_draft_id(id);
    create.mutable_draft()->set_author("Ann");
    EXPECT_OK(Call(&v1::MapEditService::Stub::CreateMapDraft, create));
    v1::AppendMapEditsRequest append;
    append.set_name(create.parent() + "/drafts/" + id);
    for (const v1::MapEdit& edit : edits) *append.add_edits() = edit;
    EXPECT_OK(Call(&v1::MapEditService::Stub::AppendMapEdits, append));
    return append.name();
  }
  absl::Status Publish(const std::string& draft, const std::string& message) {
    v1::PublishMapDraftRequest publish;
    publish.set_name(draft);
    publish.set_message(message);
    publish.set_confirm_warnings(true);
    return Call(&v1::MapEditService::Stub::PublishMapDraft, publish).status();
  }
  // Of all walls within 25 m of the map's origin.
  static v1::MapEdit WallsErased() {
    constexpr int kHalf = 500 * 256;
    v1::MapEdit edit;
    edit.set_edit_id("walls");
    edit.set_author("Ann");
    edit.set_value(v1::MapEdit::VALUE_FREE);
    edit.add_only_where(v1::MapEdit::VALUE_OCCUPIED);
    v1::LatticeRing& ring = *edit.mutable_polygon()->add_rings();
    for (const auto& [x, y] : {std::pair(-kHalf, -kHalf), {kHalf, -kHalf}, {kHalf, kHalf}, {-kHalf, kHalf}}) {
      v1::LatticePoint& point = *ring.add_points();
      point.set_x(x);
      point.set_y(y);
    }
    return edit;
  }
  // A round obstacle of 0.5 m at a point of the map's frame.
  static v1::MapEdit Pillar(const Eigen::Vector2d& at) {
    v1::MapEdit edit;
    edit.set_edit_id("pillar");
    edit.set_author("Bob");
    edit.set_value(v1::MapEdit::VALUE_OCCUPIED);
    edit.set_invisible(true);
    edit.mutable_brush()->set_radius(10 * 256);
    v1::LatticePoint& point = *edit.mutable_brush()->add_points();
    point.set_x(static_cast<int>(at.x() / 0.05 * 256));
    point.set_y(static_cast<int>(at.y() / 0.05 * 256));
    return edit;
  }
  bool IsOccupied(const std::string& map, const Eigen::Vector2d& at) {
    const grid::OccupancyGrid grid = Published(map);
    const Eigen::Vector2d cell = Inverse(grid.geometry.T_map_grid) * at / grid.geometry.resolution;
    const int column = static_cast<int>(std::floor(cell.x())), row = static_cast<int>(std::floor(cell.y()));
    return grid.geometry.contains(column, row) && grid.cells[grid.geometry.index(column, row)] > 165;
  }
  // The oldest first.
  std::vector<std::string> PublishedMessages(const std::string& map) {
    std::map<std::int64_t, std::string> messages;
    v1::ListMapDraftsRequest request;
    request.set_parent("sites/s/maps/" + map);
    request.set_state(v1::MapDraft::STATE_PUBLISHED);
    const auto response = Call(&v1::MapEditService::Stub::ListMapDrafts, request);
    EXPECT_OK(response);
    if (response.ok()) {
      for (const v1::MapDraft& draft : response->drafts()) messages[draft.edit_version()] = draft.message();
    }
    std::vector<std::string> by_version;
    for (const auto& [version, message] : messages) by_version.push_back(message);
    return by_version;
  }
  std::vector<v1::ContestedEdit> Contested(const std::string& map) {
    v1::ListContestedEditsRequest request;
    request.set_parent("sites/s/maps/" + map);
    const auto response = Call(&v1::MapEditService::Stub::ListContestedEdits, request);
    EXPECT_OK(response);
    return response.ok() ? std::vector<v1::ContestedEdit>(response->contested().begin(), response->contested().end())
                         : std::vector<v1::ContestedEdit>();
  }
};

TEST_F(RearrangedEditsTest, EditsOfAMergedMapAreEditsOfTheOtherOneAndStayContested) {
  MapBoth();
  const Eigen::Vector2d in_m(0.0, 0.0), in_m2(0.0, 0.0);  // where the robot began
  ASSERT_OK(Publish(Draw("m", "pillar", {Pillar(in_m)}), "a pillar"));
  ASSERT_OK(Publish(Draw("m2", "walls", {WallsErased()}), "no walls"));
  ASSERT_OK(Publish(Draw("m2", "pillar", {Pillar(in_m2)}), "another pillar"));
  const std::string third = CreateSessionAt("sites/s/maps/m2", Pose2());
  Map(third, Drive().second);
  const std::vector<v1::ContestedEdit> before = Contested("m2");
  ASSERT_THAT(before, Not(SizeIs(0))) << "the robot that drove there again has seen the walls";

  ASSERT_OK_AND_ASSIGN(const v1::MergeMapsResponse merged, Merge());
  EXPECT_THAT(PublishedMessages("m"), ElementsAre("a pillar", "no walls", "another pillar"));
  EXPECT_TRUE(IsOccupied("m", in_m));
  EXPECT_TRUE(IsOccupied("m", Drive().T_first_second * in_m2));
  const std::vector<v1::ContestedEdit> after = Contested("m");
  ASSERT_THAT(after, Not(SizeIs(0))) << "nothing is settled by merging";
  EXPECT_EQ(after[0].message(), "no walls");
  EXPECT_EQ(after[0].authors(0), "Ann");
  for (const v1::ContestedEdit& place : after) EXPECT_EQ(place.session(), third);
  EXPECT_EQ(CountRearrangedVersions(), 1);

  ASSERT_OK(Undo(merged.rearrangement().name()));
  EXPECT_TRUE(IsOccupied("m2", in_m2));
  EXPECT_THAT(Contested("m2"), SizeIs(before.size()));
  EXPECT_TRUE(IsOccupied("m", in_m));
  ASSERT_OK(Merge());
  EXPECT_THAT(PublishedMessages("m"), SizeIs(3)) << "the same edits come once";
}

TEST_F(RearrangedEditsTest, DraftsOfAMergedMapAreDraftsOfTheOtherOne) {
  MapBoth();
  const Eigen::Vector2d place(0.0, 0.0);  // where the robot began in m2
  ASSERT_OK(Publish(Draw("m2", "walls", {WallsErased()}), "no walls"));
  const std::string draft = Draw("m2", "pillar", {Pillar(place)});
  const std::string taken = Draw("m", "pillar", {});
  ASSERT_OK(Merge());

  v1::GetMapDraftRequest old;
  old.set_name(draft);
  EXPECT_STATUS(Call(&v1::MapEditService::Stub::GetMapDraft, old).status(), absl::StatusCode::kNotFound,
                HasSubstr("sites/s/maps/m2 was merged into sites/s/maps/m"));
  v1::AppendMapEditsRequest late;
  late.set_name(draft);
  *late.add_edits() = Pillar(place);
  late.mutable_edits(0)->set_edit_id("late");
  EXPECT_STATUS(Call(&v1::MapEditService::Stub::AppendMapEdits, late).status(), absl::StatusCode::kNotFound,
                HasSubstr("its drafts with it"));
  EXPECT_STATUS(Publish(draft, "late"), absl::StatusCode::kNotFound, HasSubstr("its drafts with it"));
  v1::CreateMapDraftRequest create;
  create.set_parent("sites/s/maps/m2");
  EXPECT_STATUS(Call(&v1::MapEditService::Stub::CreateMapDraft, create).status(), absl::StatusCode::kNotFound,
                HasSubstr("merged into"));

  v1::ListMapDraftsRequest list;
  list.set_parent("sites/s/maps/m");
  list.set_state(v1::MapDraft::STATE_OPEN);
  ASSERT_OK_AND_ASSIGN(const auto drafts, Call(&v1::MapEditService::Stub::ListMapDrafts, list));
  ASSERT_THAT(drafts.drafts(), SizeIs(2)) << "one id was taken";
  const auto moved = std::find_if(drafts.drafts().begin(), drafts.drafts().end(),
                                  [&](const v1::MapDraft& one) { return one.name() != taken; });
  EXPECT_EQ(moved->active_edits(), 1);
  EXPECT_EQ(moved->base_edit_version(), 1) << "over what it was drawn over";
  ASSERT_OK(Publish(moved->name(), "a pillar"));
  EXPECT_TRUE(IsOccupied("m", Drive().T_first_second * place));
  EXPECT_THAT(PublishedMessages("m"), ElementsAre("no walls", "a pillar"));
}

}  // namespace
}  // namespace enfilade::testing

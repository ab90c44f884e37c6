// SPDX-License-Identifier: Apache-2.0
// What becomes of areas when maps are merged and split.
#include <gmock/gmock.h>

#include "storage/maps/map_area_store.h"
#include "tests/contract/storage/postgres_rearrangements.h"

namespace enfilade::testing {
namespace {

using storage::MapArea;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class RearrangedAreasTest : public RearrangementRowsTest {
 protected:
  // A square of 0.2 m.
  void Draw(const std::string& map, const std::string& id, double x, double y) {
    MapArea area;
    area.site = site_;
    area.map = MapId(map);
    area.id = MapAreaId(id);
    area.area.display_name = id + " of " + map;
    area.area.outline = {{x, y}, {x + 0.2, y}, {x + 0.2, y + 0.2}, {x, y + 0.2}};
    ASSERT_OK(areas_.Create(Soon(), area, "request of " + map + id, true));
  }
  std::vector<MapArea> AreasOf(const std::string& map) {
    const auto listed = areas_.List(Soon(), site_, MapId(map), {});
    EXPECT_OK(listed.status());
    return listed.ok() ? *listed : std::vector<MapArea>();
  }
  std::vector<std::string> NamesIn(const std::string& map) {
    std::vector<std::string> names;
    for (const MapArea& area : AreasOf(map)) names.push_back(area.area.display_name);
    return names;
  }

  const storage::MapAreaStore areas_{*pool_};
};

TEST_F(RearrangedAreasTest, ThoseOfAMergedMapFollowIntoTheNewFrame) {
  Draw("lab", "bench", 1, 2);
  Draw("hall", "sofa", 7, 8);
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  EXPECT_THAT(NamesIn("hall"), ElementsAre("bench of lab", "sofa of hall"));
  const MapArea bench = AreasOf("hall").at(0);
  EXPECT_EQ(bench.id, MapAreaId("bench"));
  const std::vector<Eigen::Vector2d> drawn = {{1, 2}, {1.2, 2}, {1.2, 2.2}, {1, 2.2}};
  ASSERT_EQ(bench.area.outline.size(), drawn.size());
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    EXPECT_NEAR((bench.area.outline[i] - kHallLab * drawn[i]).norm(), 0.0, 1e-12);
  }
  // Its old name leads to it.
  ASSERT_OK_AND_ASSIGN(const MapArea by_old_name, areas_.Get(Soon(), site_, lab_, MapAreaId("bench")));
  EXPECT_EQ(by_old_name.map, map_);
  EXPECT_THAT(NamesIn("lab"), ElementsAre("bench of lab", "sofa of hall"));
  // Under the old name nothing is changed, as with maps.
  MapArea late = bench;
  late.map = lab_;
  EXPECT_CODE(areas_.Update(Soon(), late, false), absl::StatusCode::kNotFound);
  EXPECT_CODE(areas_.Delete(Soon(), site_, lab_, late.id, 0), absl::StatusCode::kNotFound);
  EXPECT_CODE(areas_.Create(Soon(), late, "", false), absl::StatusCode::kNotFound);
}

TEST_F(RearrangedAreasTest, AnIdThatIsTakenGetsAnEnding) {
  Draw("lab", "bench", 1, 2);
  Draw("hall", "bench", 7, 8);
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  const std::vector<MapArea> areas = AreasOf("hall");
  ASSERT_EQ(areas.size(), 2U);
  EXPECT_EQ(areas[0].id, MapAreaId("bench"));
  EXPECT_EQ(areas[0].area.display_name, "bench of hall");
  EXPECT_THAT(areas[1].id.value(), HasSubstr("bench-"));
  EXPECT_TRUE(IsValidResourceId(areas[1].id.value()));
  EXPECT_EQ(areas[1].area.display_name, "bench of lab");
}

TEST_F(RearrangedAreasTest, UndoingAMergeBringsThemBackBitForBit) {
  Draw("lab", "bench", 1.0 / 3.0, 2.0 / 7.0);
  Draw("hall", "bench", 7, 8);
  const std::string before = AllRows();
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  EXPECT_NE(AllRows(), before);
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")));
  EXPECT_EQ(AllRows(), before);
}

TEST_F(RearrangedAreasTest, AMergeWhoseAreasWereChangedSinceIsNotUndone) {
  Draw("lab", "bench", 1, 2);
  Draw("hall", "sofa", 7, 8);
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  // One that did not move may change, and a new one may come.
  MapArea sofa = AreasOf("hall").at(1);
  sofa.area.display_name = "Couch";
  ASSERT_OK(areas_.Update(Soon(), sofa, false));
  Draw("hall", "new", 9, 9);
  MapArea bench = AreasOf("hall").at(0);
  bench.area.display_name = "Table";
  ASSERT_OK_AND_ASSIGN(bench, areas_.Update(Soon(), bench, false));
  EXPECT_STATUS(store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")), absl::StatusCode::kFailedPrecondition,
                HasSubstr("area hall/bench has been changed since"));
  EXPECT_THAT(NamesIn("hall"), ElementsAre("Table", "new of hall", "Couch"));
}

// Of the lab's session, which leaves the hall again, the keyframes are at (0.33, 2) and (0.29, -2) in the lab's frame.
TEST_F(RearrangedAreasTest, AtASplitTheyGoWithTheKeyframesNearThem) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  Draw("hall", "far-left", -30, 0);   // nearer to s1's keyframes, at about (0.3, +-1)
  Draw("hall", "far-right", 40, 5);   // nearer to s2's, at about (2, 5) and (6, 5)
  Draw("hall", "between", 1.5, 2.5);  // near to both
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  EXPECT_THAT(NamesIn("hall"), ElementsAre("between of hall", "far-left of hall"));
  EXPECT_THAT(NamesIn("annex"), ElementsAre("between of hall", "far-right of hall"));
  const Pose2 T_annex_hall{1, 2, 0.5};
  EXPECT_NEAR((AreasOf("annex").at(1).area.outline[0] - T_annex_hall * Eigen::Vector2d(40, 5)).norm(), 0.0, 1e-12);
}

TEST_F(RearrangedAreasTest, UndoingASplitBringsThemBackBitForBit) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  Draw("hall", "far-right", 40, 5);
  Draw("hall", "between", 1.5, 2.5);
  const std::string before = AllRows();
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  // What is drawn in a map that would disappear is not lost.
  Draw("annex", "late", 1, 1);
  EXPECT_STATUS(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")), absl::StatusCode::kFailedPrecondition,
                HasSubstr("area late has come into map annex since"));
  ASSERT_OK(areas_.Delete(Soon(), site_, MapId("annex"), MapAreaId("late"), 0));
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
  database_.Sql("DELETE FROM map_layer_tiles WHERE map_id = 'annex'");
  database_.Sql("DELETE FROM maps WHERE map_id = 'annex'");
  EXPECT_EQ(AllRows(), before);
}

}  // namespace
}  // namespace enfilade::testing

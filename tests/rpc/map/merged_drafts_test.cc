// SPDX-License-Identifier: Apache-2.0
// Drafts of one map that are published one after the other.
#include <algorithm>

#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "tests/rpc/map/map_edit_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class MergedDraftsTest : public MapEditFixture {};

TEST_F(MergedDraftsTest, DraftsThatDoNotMeetAreMerged) {
  ImportRoom();
  const std::string first = CreateDraft("first");
  const std::string second = CreateDraft("second");
  ASSERT_OK(Append(first, {Brush("a", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  ASSERT_OK(Append(second, {Brush("b", v1::MapEdit::VALUE_OCCUPIED, {{30, 10}}, 1.0)}));
  ASSERT_OK(Publish(first, "first"));
  ASSERT_OK_AND_ASSIGN(const auto published, Publish(second, "second"));
  EXPECT_EQ(published.merged_publications(), 1);
  EXPECT_TRUE(IsOccupied(10, 10));
  EXPECT_TRUE(IsOccupied(30, 10));
}

TEST_F(MergedDraftsTest, DraftsThatContradictEachOtherAreSettledByPeople) {
  for (const bool mine : {true, false}) {
    ImportRoom();  // ends the edits of before
    const std::string suffix = mine ? "-mine" : "-theirs";
    const std::string first = CreateDraft("first" + suffix);
    const std::string second = CreateDraft("second" + suffix);
    v1::MapEdit theirs = Brush("a", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 2.0);
    theirs.set_author("Ada");
    v1::MapEdit ours = Brush("b", v1::MapEdit::VALUE_UNKNOWN, {{11, 10}}, 2.0);
    ours.set_author("Ben");
    ASSERT_OK(Append(first, {theirs}));
    ASSERT_OK(Append(second, {ours}));
    ASSERT_OK(Publish(first, "first"));
    EXPECT_STATUS(Publish(second, "second").status(), absl::StatusCode::kAborted, HasSubstr("RebaseMapDraft"));
    ASSERT_OK_AND_ASSIGN(const v1::CheckMapDraftResponse check, Check(second));
    ASSERT_THAT(check.conflicts(), SizeIs(1));
    EXPECT_THAT(check.conflicts(0).my_authors(), ElementsAre("Ben"));
    EXPECT_THAT(check.conflicts(0).their_authors(), ElementsAre("Ada"));
    EXPECT_STATUS(Rebase(second, check.edit_version() + 1, check.conflicts(0).box(), mine).status(),
                  absl::StatusCode::kAborted, HasSubstr("is the newest"));
    ASSERT_OK(Rebase(second, check.edit_version(), check.conflicts(0).box(), mine));
    ASSERT_OK(Publish(second, "second"));
    EXPECT_EQ(IsOccupied(11, 10), !mine) << "both drew it";
    EXPECT_TRUE(IsOccupied(8, 10)) << "only the first drew it";
    EXPECT_FALSE(IsOccupied(13, 10)) << "only the second drew it";
  }
}

// An L and, within its box, a dot.
TEST_F(MergedDraftsTest, AConflictWithinTheBoxOfAnotherHasAResolutionOfItsOwn) {
  ImportRoom();
  const std::string first = CreateDraft("first"), second = CreateDraft("second");
  for (const auto& [draft, value] :
       {std::pair(first, v1::MapEdit::VALUE_OCCUPIED), {second, v1::MapEdit::VALUE_UNKNOWN}}) {
    ASSERT_OK(
        Append(draft, {Brush("L", value, {{10, 20}, {10, 10}, {20, 10}}, 0.0), Brush("dot", value, {{17, 17}}, 0.0)}));
  }
  ASSERT_OK(Publish(first, "first"));
  ASSERT_OK_AND_ASSIGN(const v1::CheckMapDraftResponse check, Check(second));
  ASSERT_THAT(check.conflicts(), SizeIs(2));
  std::vector<std::pair<v1::CellBox, bool>> is_mine;
  for (const v1::MapEditConflict& conflict : check.conflicts()) {
    is_mine.emplace_back(conflict.box(), conflict.box().width() == 1);
  }
  std::sort(is_mine.begin(), is_mine.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  ASSERT_OK(Rebase(second, check.edit_version(), is_mine));
  ASSERT_OK(Publish(second, "second"));
  EXPECT_TRUE(IsOccupied(10, 15)) << "theirs";
  EXPECT_FALSE(IsOccupied(17, 17)) << "mine";
}

TEST_F(MergedDraftsTest, TakingTheirsLeavesWhatIsNotInConflict) {
  ImportRoom();
  const std::string first = CreateDraft("first");
  const std::string second = CreateDraft("second");
  // Theirs is an L; ours covers its box.
  ASSERT_OK(Append(first, {Brush("a", v1::MapEdit::VALUE_OCCUPIED, {{10, 20}, {10, 10}, {20, 10}}, 0.0)}));
  ASSERT_OK(Append(second, {Patch("b", v1::MapEdit::VALUE_UNKNOWN, Box(10, 10, 11, 11))}));
  ASSERT_OK(Publish(first, "first"));
  ASSERT_OK_AND_ASSIGN(const v1::CheckMapDraftResponse check, Check(second));
  ASSERT_THAT(check.conflicts(), SizeIs(1));
  EXPECT_EQ(check.conflicts(0).cells(), 21);
  ASSERT_OK(Rebase(second, check.edit_version(), check.conflicts(0).box(), /*mine=*/false));
  ASSERT_OK_AND_ASSIGN(const auto published, Publish(second, "second"));
  EXPECT_EQ(published.changes().to_unknown(), 11 * 11 - 21);
  EXPECT_TRUE(IsOccupied(10, 20));
}

}  // namespace
}  // namespace enfilade::testing

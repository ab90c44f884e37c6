// SPDX-License-Identifier: Apache-2.0
// MapEditService: drafts, and what becomes of published edits whatever is mapped and imported after them.
#include <algorithm>
#include <map>
#include <thread>

#include "client/sdk/api/map_export.h"
#include "client/sdk/api/map_import.h"
#include "core/edit/overlay.h"
#include "core/grid/files/map_files.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "tests/rpc/map/map_edit_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class MapEditTest : public MapEditFixture {};

TEST_F(MapEditTest, APublishedStrokeChangesExactlyItsCells) {
  ImportRoom();
  const std::string before = ExportedPixels();
  const std::string draft = CreateDraft("d");
  ASSERT_OK(Append(draft, {Brush("e1", v1::MapEdit::VALUE_OCCUPIED, {{10, 12}}, 2.0)}));
  ASSERT_OK_AND_ASSIGN(const v1::PublishMapDraftResponse published, Publish(draft, "a pillar"));
  EXPECT_EQ(published.revision().name(), "sites/s/maps/m/revisions/2");
  EXPECT_EQ(published.revision().source(), v1::MapRevision::SOURCE_EDIT);
  EXPECT_EQ(published.revision().edit_version(), 1);
  EXPECT_EQ(published.draft().state(), v1::MapDraft::STATE_PUBLISHED);
  EXPECT_EQ(published.changes().to_occupied(), 13);  // cells within 2 of the middle of one
  const std::string after = ExportedPixels();
  ASSERT_EQ(after.size(), before.size());
  int changed = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i] == before[i]) continue;
    ++changed;
    const int column = static_cast<int>(i % kWidth);
    const int row = kHeight - 1 - static_cast<int>(i / kWidth);
    EXPECT_LE((column - 10) * (column - 10) + (row - 12) * (row - 12), 4);
    EXPECT_EQ(after[i], '\0');
  }
  EXPECT_EQ(changed, 13);
  EXPECT_EQ(ExportedPixels(/*without_edits=*/true), before);
}

TEST_F(MapEditTest, ADraftThatIsDrawnAndUndoneChangesNothing) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  std::vector<std::string> ids;
  for (int i = 0; i < 50; ++i) {
    ids.push_back("e" + std::to_string(i));
    ASSERT_OK(Append(draft, {Brush(ids.back(), i % 2 == 0 ? v1::MapEdit::VALUE_FREE : v1::MapEdit::VALUE_UNKNOWN,
                                   {{i % 40, i % 30}, {i % 30 + 5, 20}}, 1.5)}));
  }
  ASSERT_OK_AND_ASSIGN(const auto undone, SetActive(draft, ids, false));
  EXPECT_FALSE(undone.tiles().empty());
  for (const v1::MapEditTile& tile : undone.tiles()) EXPECT_EQ(tile.sha256(), edit::DigestOf(nullptr));
  EXPECT_STATUS(Publish(draft, "nothing").status(), absl::StatusCode::kFailedPrecondition,
                HasSubstr("no active edits"));
  EXPECT_EQ(ExportedPixels(), RoomPixels());
  ASSERT_OK_AND_ASSIGN(const auto redone, SetActive(draft, {"e7"}, true));
  ASSERT_THAT(redone.edits(), SizeIs(1));
  EXPECT_TRUE(redone.edits(0).active());
}

TEST_F(MapEditTest, NobodyUndoesAnothersEditByChance) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  v1::MapEdit edit = Brush("mine", v1::MapEdit::VALUE_FREE, {{5, 5}}, 1.0);
  edit.set_author("Ada");
  ASSERT_OK(Append(draft, {edit}));
  EXPECT_STATUS(SetActive(draft, {"mine"}, false, "Ben").status(), absl::StatusCode::kFailedPrecondition,
                HasSubstr("by \"Ada\""));
  EXPECT_OK(SetActive(draft, {"mine"}, false, "Ada"));
  EXPECT_STATUS(SetActive(draft, {"never drawn"}, false, "Ada").status(), absl::StatusCode::kNotFound,
                HasSubstr("never drawn"));
}

TEST_F(MapEditTest, SendingAgainIsSafe) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  const v1::MapEdit edit = Brush("e", v1::MapEdit::VALUE_FREE, {{5, 5}}, 1.0);
  ASSERT_OK_AND_ASSIGN(const auto first, Append(draft, {edit}));
  ASSERT_OK_AND_ASSIGN(const auto second, Append(draft, {edit}));
  EXPECT_EQ(first.head(), second.head());
  EXPECT_THAT(second.edits(), IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto published, Publish(draft, "once"));
  ASSERT_OK_AND_ASSIGN(const auto again, Publish(draft, "once"));
  EXPECT_EQ(published.revision().name(), again.revision().name());
  EXPECT_STATUS(Publish(draft, "twice").status(), absl::StatusCode::kFailedPrecondition, HasSubstr("is published"));
  EXPECT_STATUS(Append(draft, {Brush("late", v1::MapEdit::VALUE_FREE, {{6, 6}}, 1.0)}).status(),
                absl::StatusCode::kFailedPrecondition, HasSubstr("make a new draft"));
}

TEST_F(MapEditTest, AFillBecomesThePatchThatItFilled) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  v1::MapEdit fill;
  fill.set_edit_id("f");
  fill.set_value(v1::MapEdit::VALUE_UNKNOWN);
  *fill.mutable_fill()->mutable_seed() = At(10, 10);
  *fill.mutable_fill()->mutable_bounds() = Box(0, 0, kWidth, kHeight);
  ASSERT_OK_AND_ASSIGN(const auto appended, Append(draft, {fill}));
  ASSERT_THAT(appended.edits(), SizeIs(1));
  ASSERT_TRUE(appended.edits(0).has_patch());
  ASSERT_OK_AND_ASSIGN(const auto published, Publish(draft, "nobody knows"));
  EXPECT_EQ(published.changes().to_unknown(), (kWidth - 2) * (kHeight - 2));  // all within the walls

  v1::MapEdit walls = Brush("w", v1::MapEdit::VALUE_FREE, {{0, 0}, {kWidth - 1, 0}}, 3.0);
  walls.add_only_where(v1::MapEdit::VALUE_OCCUPIED);
  const std::string second = CreateDraft("second");
  ASSERT_OK(Append(second, {walls}));
  ASSERT_OK_AND_ASSIGN(const auto opened, Publish(second, "the lower wall is gone"));
  EXPECT_EQ(opened.changes().to_free(), kWidth + 2 * 3);  // its row, and three cells of each side's
}

TEST_F(MapEditTest, AnImportEndsTheEditsUnlessTheyAreKept) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  ASSERT_OK(Append(draft, {Brush("e", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  ASSERT_OK(Publish(draft, "a pillar"));
  ImportRoom(/*keep_edits=*/true);
  EXPECT_TRUE(IsOccupied(10, 10));
  ImportRoom();
  EXPECT_FALSE(IsOccupied(10, 10));
  EXPECT_EQ(ExportedPixels(), RoomPixels());
  // What was published then does not come back.
  const std::string next = CreateDraft("next");
  ASSERT_OK(Append(next, {Brush("n", v1::MapEdit::VALUE_OCCUPIED, {{30, 10}}, 1.0)}));
  ASSERT_OK_AND_ASSIGN(const auto published, Publish(next, "another pillar"));
  EXPECT_EQ(published.revision().edit_version(), 2);
  EXPECT_FALSE(IsOccupied(10, 10));
  EXPECT_TRUE(IsOccupied(30, 10));
}

TEST_F(MapEditTest, ADraftShowsNoEditsThatAnImportHasEnded) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  ASSERT_OK(Append(draft, {Brush("e", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  ASSERT_OK(Publish(draft, "a pillar"));
  v1::ReadMapDraftTilesRequest request;
  request.set_name(CreateDraft("open"));
  request.add_tiles();
  const auto published_at_pillar = [&] {
    const auto response = Call(&v1::MapEditService::Stub::ReadMapDraftTiles, request);
    EXPECT_OK(response);
    return response.ok() ? response->tiles(0).cells()[10 * 256 + 10] >> 4 : -1;
  };
  EXPECT_EQ(published_at_pillar(), 3);
  ImportRoom();
  EXPECT_EQ(published_at_pillar(), 0);
}

// The room is imported again with its corner at (-1 m, 0.5 m): its cells have other numbers.
TEST_F(MapEditTest, ADraftGoesOnWhereTheMapsCellsAreOthers) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  ASSERT_OK(Append(draft, {Brush("a", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  ImportRoom(true, "-1, 0.5");
  v1::ReadMapDraftTilesRequest request;
  request.set_name(draft);
  request.add_tiles();
  ASSERT_OK_AND_ASSIGN(const auto tiles, Call(&v1::MapEditService::Stub::ReadMapDraftTiles, request));
  const auto seen_at = [&](int column, int row) {
    return tiles.tiles(0).cells()[static_cast<std::size_t>(row * 256 + column)] & 3;
  };
  EXPECT_EQ(tiles.box().first_column(), -10);
  EXPECT_EQ(tiles.box().first_row(), 5);
  EXPECT_EQ(tiles.box().width(), kWidth);
  EXPECT_EQ(tiles.box().height(), kHeight);
  EXPECT_EQ(seen_at(0, 4), 0) << "below the room";
  EXPECT_EQ(seen_at(0, 5), 2) << "its lower wall";
  EXPECT_EQ(seen_at(0, 6), 1);
  EXPECT_EQ(seen_at(kWidth - 11, 20), 2) << "its right wall";
  v1::MapEdit where_free = Brush("b", v1::MapEdit::VALUE_UNKNOWN, {{0, 5}}, 1.0);
  where_free.add_only_where(v1::MapEdit::VALUE_FREE);
  ASSERT_OK_AND_ASSIGN(const auto appended, Append(draft, {where_free}));
  ASSERT_OK(Publish(draft, "after it moved", /*confirm=*/true));
  EXPECT_TRUE(IsOccupied(20, 5)) << "where it was drawn, in the cells of now";
  EXPECT_TRUE(IsOccupied(10, 0)) << "the wall was not free";
  EXPECT_FALSE(IsOccupied(10, 1));
}

TEST_F(MapEditTest, WhatAFormatCannotSayIsRefused) {
  ImportJson();
  const std::string draft = CreateDraft("d");
  EXPECT_STATUS(Append(draft, {Brush("e", v1::MapEdit::VALUE_UNKNOWN, {{1, 1}}, 1.0)}).status(),
                absl::StatusCode::kFailedPrecondition, HasSubstr("JSON"));
  EXPECT_OK(Append(draft, {Brush("f", v1::MapEdit::VALUE_OCCUPIED, {{1, 1}}, 0.0)}));
}

TEST_F(MapEditTest, BadEditsAreRefusedByName) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  const auto refused = [&](const v1::MapEdit& edit, const std::string& why) {
    EXPECT_STATUS(Append(draft, {edit}).status(), absl::StatusCode::kInvalidArgument,
                  ::testing::AllOf(HasSubstr("edits[0]"), HasSubstr(why)));
  };
  refused(v1::MapEdit(), "edit_id");
  refused(Brush("e", v1::MapEdit::VALUE_UNSPECIFIED, {{1, 1}}, 1.0), "value");
  refused(Brush("e", v1::MapEdit::VALUE_FREE, {}, 1.0), "no points");
  refused(Brush("e", v1::MapEdit::VALUE_FREE, {{kWidth + 10, 5}}, 1.0), "outside of the map");
  refused(Brush("e", v1::MapEdit::VALUE_FREE, {{1, 1}, {100'000, 1}}, 1.0), "longer than");
  v1::MapEdit bow_tie;
  bow_tie.set_edit_id("e");
  bow_tie.set_value(v1::MapEdit::VALUE_FREE);
  v1::LatticeRing& ring = *bow_tie.mutable_polygon()->add_rings();
  for (const auto& [column, row] : {std::pair{2, 2}, {20, 20}, {20, 2}, {2, 20}}) *ring.add_points() = At(column, row);
  refused(bow_tie, "cross");
  v1::MapEdit many = Brush("e", v1::MapEdit::VALUE_FREE, {}, 1.0);
  for (int i = 0; i < 10'001; ++i) *many.mutable_brush()->add_points() = At(5, 5);
  refused(many, "at most 10000");
  EXPECT_THAT(*Edits(draft), IsEmpty()) << "nothing half";

  EXPECT_STATUS(Append("sites/s/maps/m/drafts/none", {Brush("e", v1::MapEdit::VALUE_FREE, {{1, 1}}, 1.0)}).status(),
                absl::StatusCode::kNotFound, HasSubstr("drafts/none"));
  EXPECT_STATUS(Publish(draft, "").status(), absl::StatusCode::kInvalidArgument, HasSubstr("message"));
  v1::DeleteMapDraftRequest stale;
  stale.set_name(draft);
  stale.set_etag("17");
  EXPECT_CODE(Call(&v1::MapEditService::Stub::DeleteMapDraft, stale), absl::StatusCode::kAborted);
}

TEST_F(MapEditTest, OfTwoPublishesAtOnceOneComesFirst) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  ASSERT_OK(Append(draft, {Brush("e", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  std::array<absl::Status, 2> results;
  std::array<std::thread, 2> callers;
  for (std::size_t i = 0; i < 2; ++i) {
    callers[i] = std::thread([&, i] { results[i] = Publish(draft, "by " + std::to_string(i)).status(); });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_NE(results[0].ok(), results[1].ok());
  EXPECT_CODE(results[results[0].ok() ? 1 : 0], absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.map_revisions WHERE source = 3"), "1");
}

TEST_F(MapEditTest, ADraftThatSaysTheSameAsTheOneBeforeIsARevisionOfItsOwn) {
  ImportRoom();
  const std::string first = CreateDraft("first");
  const std::string second = CreateDraft("second");
  ASSERT_OK(Append(first, {Brush("a", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  ASSERT_OK(Append(second, {Brush("b", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  ASSERT_OK(Publish(first, "first"));
  ASSERT_OK_AND_ASSIGN(const auto published, Publish(second, "second"));
  EXPECT_EQ(published.revision().name(), "sites/s/maps/m/revisions/3");
  EXPECT_EQ(published.revision().edit_version(), 2);
  EXPECT_EQ(published.draft().edit_version(), 2);
}

TEST_F(MapEditTest, AWatcherIsToldEditsPresencesAndPublications) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  ASSERT_OK(Append(draft, {Brush("before", v1::MapEdit::VALUE_FREE, {{5, 5}}, 1.0)}));
  DraftStream stream(*connection_, draft);
  const v1::WatchMapDraftResponse first = stream.Receive();
  ASSERT_THAT(first.edits(), SizeIs(1));
  EXPECT_EQ(first.draft().name(), draft);
  const auto has_edits = [](const v1::WatchMapDraftResponse& message) { return message.edits_size() > 0; };
  ASSERT_OK(Append(draft, {Brush("after", v1::MapEdit::VALUE_FREE, {{9, 5}}, 1.0)}));
  const v1::WatchMapDraftResponse second = stream.ReceiveUntil(has_edits);
  ASSERT_THAT(second.edits(), SizeIs(1));
  EXPECT_EQ(second.edits(0).edit_id(), "after");
  v1::ReportMapDraftPresenceRequest presence;
  presence.set_name(draft);
  presence.mutable_presence()->set_client_id("window");
  presence.mutable_presence()->set_author("Ada");
  *presence.mutable_presence()->mutable_pointer() = At(3, 4);
  ASSERT_OK(Call(&v1::MapEditService::Stub::ReportMapDraftPresence, presence));
  const v1::WatchMapDraftResponse third =
      stream.ReceiveUntil([](const auto& message) { return message.presences_changed(); });
  ASSERT_THAT(third.presences(), SizeIs(1));
  EXPECT_EQ(third.presences(0).author(), "Ada");
  ASSERT_OK(Publish(draft, "done"));
  const v1::WatchMapDraftResponse last = stream.ReceiveUntil([](const auto& message) { return message.has_draft(); });
  EXPECT_EQ(last.draft().state(), v1::MapDraft::STATE_PUBLISHED);
  EXPECT_EQ(last.edit_version(), 1);
}

TEST_F(MapEditTest, LinkPointsInTheWayAreNamedBeforeItIsTooLate) {
  ImportRoom();
  AddCandidate("left", 5.5, 10.5);
  AddCandidate("right", 40.5, 10.5);
  const std::string draft = CreateDraft("d");
  v1::MapEdit wall;
  wall.set_edit_id("wall");
  wall.set_value(v1::MapEdit::VALUE_OCCUPIED);
  *wall.mutable_line()->add_points() = At(20, 0);
  *wall.mutable_line()->add_points() = At(20, kHeight - 1);
  ASSERT_OK(Append(draft, {wall, Brush("pillar", v1::MapEdit::VALUE_OCCUPIED, {{41, 11}}, 1.0)}));
  EXPECT_STATUS(Publish(draft, "a wall").status(), absl::StatusCode::kFailedPrecondition,
                HasSubstr("confirm_warnings"));
  ASSERT_OK_AND_ASSIGN(const v1::CheckMapDraftResponse check, Check(draft));
  std::string all;
  for (const v1::MapEditProblem& problem : check.problems()) all += problem.message() + "\n";
  EXPECT_THAT(all, HasSubstr("linkPoints/right is cut off from"));
  EXPECT_THAT(all, HasSubstr("of sites/s/linkPoints/right: robots may no longer get through"));
  EXPECT_OK(Publish(draft, "a wall", /*confirm=*/true));
}

// A robot maps a room; people erase a part of a wall and draw a glass wall; another robot maps the room again.
TEST_F(MapEditTest, EditsOutliveWhatRobotsMapAfterThem) {
  MapLap();
  const v1::CellBox ghost = OccupiedBlock();
  const v1::CellBox glass = FreeBlock();
  const std::string draft = CreateDraft("d");
  v1::MapEdit erased = Patch("ghost", v1::MapEdit::VALUE_FREE, ghost);
  v1::MapEdit drawn = Patch("glass", v1::MapEdit::VALUE_OCCUPIED, glass);
  drawn.set_invisible(true);
  ASSERT_OK(Append(draft, {erased, drawn}));
  ASSERT_OK(Publish(draft, "a ghost and a glass wall", /*confirm=*/true));
  EXPECT_THAT(*Contested(), IsEmpty());

  const std::string session = MapLap();
  EXPECT_TRUE(Shows(ghost, v1::MapEdit::VALUE_FREE));
  EXPECT_TRUE(Shows(glass, v1::MapEdit::VALUE_OCCUPIED));
  ASSERT_OK_AND_ASSIGN(const auto contested, Contested());
  ASSERT_THAT(contested, SizeIs(1)) << "what cannot be seen is not contested by who does not see it";
  EXPECT_EQ(contested[0].session(), session);
  EXPECT_EQ(contested[0].edited(), v1::MapEdit::VALUE_FREE);
  EXPECT_EQ(contested[0].seen(), v1::MapEdit::VALUE_OCCUPIED);
  EXPECT_GE(contested[0].cells(), 4);
  EXPECT_EQ(contested[0].message(), "a ghost and a glass wall");

  ASSERT_OK(Settle(contested[0], v1::ContestSettlement::CHOICE_KEEP));
  EXPECT_THAT(*Contested(), IsEmpty());
  EXPECT_TRUE(Shows(ghost, v1::MapEdit::VALUE_FREE));
  EXPECT_CODE(Settle(contested[0], v1::ContestSettlement::CHOICE_DROP), absl::StatusCode::kAborted);

  MapLap();
  ASSERT_OK_AND_ASSIGN(const auto again, Contested());
  ASSERT_FALSE(again.empty()) << "seen once more, by who came after it was said again";
  for (const v1::ContestedEdit& place : again) ASSERT_OK(Settle(place, v1::ContestSettlement::CHOICE_DROP));
  EXPECT_FALSE(Shows(ghost, v1::MapEdit::VALUE_FREE)) << "what robots see";
  EXPECT_TRUE(Shows(glass, v1::MapEdit::VALUE_OCCUPIED));
}

TEST_F(MapEditTest, HitsInAnAreaWhereTheyAreIgnoredAreNotMapped) {
  MapLap();
  const v1::CellBox ghost = OccupiedBlock();
  ASSERT_GT(Look().Count(ghost, grid::CellClass::kOccupied), 0);
  const std::string area = IgnoreHitsIn(ghost);
  EXPECT_EQ(Look().Count(ghost, grid::CellClass::kOccupied), 0);
  MapLap();
  EXPECT_EQ(Look().Count(ghost, grid::CellClass::kOccupied), 0);
  v1::DeleteMapAreaRequest request;
  request.set_name(area);
  ASSERT_OK(Call(&v1::MapAreaService::Stub::DeleteMapArea, request));
  EXPECT_GT(Look().Count(ghost, grid::CellClass::kOccupied), 0);
}

}  // namespace
}  // namespace enfilade::testing

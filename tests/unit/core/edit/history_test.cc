// SPDX-License-Identifier: Apache-2.0
#include "core/edit/history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/edit/patches.h"
#include "tests/unit/core/edit/covered_cells.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

using grid::CellClass;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Rows = std::vector<std::string>;

const Lattice kLattice{0.05, {}};

// One edit for each value in the picture, in the order unknown, free, occupied, clear.
std::vector<KeptEdit> Drawn(const Rows& picture, const std::string& author = "ann", bool invisible = false) {
  const Overlay overlay = OverlayIn(picture);
  const CellBox box{0, 0, static_cast<int>(picture[0].size()), static_cast<int>(picture.size())};
  std::vector<KeptEdit> edits;
  for (const char letter : {'?', '-', '#', 'x'}) {
    Overlay marks;
    for (int row = 0; row < box.height; ++row) {
      for (int column = 0; column < box.width; ++column) {
        if (overlay.At(column, row) != InstructionOf(letter)) continue;
        marks.Draw({Instruction::kOccupied, Line{{Centre(column, row)}}, false});
      }
    }
    if (marks.empty()) continue;
    edits.push_back({author + letter,
                     author,
                     static_cast<std::int64_t>(edits.size()) + 1,
                     true,
                     kLattice,
                     {InstructionOf(letter), PatchOf(marks, box), invisible}});
  }
  return edits;
}

std::vector<KeptEdit> Joined(std::vector<KeptEdit> edits, const std::vector<KeptEdit>& later) {
  edits.insert(edits.end(), later.begin(), later.end());
  return edits;
}

Publication Published(std::int64_t version, const Rows& picture, const std::string& author = "bob",
                      bool invisible = false) {
  return {version, "of " + author, Drawn(picture, author, invisible)};
}

TEST(History, PublicationsLieOverEachOther) {
  const std::vector<Publication> publications = {Published(1, {"####", "####"}), Published(2, {".-x?", "x..-"}),
                                                 Published(3, {"..-x", "...."})};
  EXPECT_EQ(PictureOf(OverlayOf(publications, kLattice), {0, 0, 4, 2}), (Rows{"#--.", ".##-"}));
  EXPECT_TRUE(OverlayOf({}, kLattice).empty());
  EXPECT_TRUE(OverlayOf({Published(1, {"#-"}), Published(2, {"xx"})}, kLattice).empty());
}

TEST(History, OnlyActiveEditsAreDrawn) {
  std::vector<KeptEdit> edits = Joined(Drawn({"###"}), Drawn({".--"}));
  EXPECT_EQ(PictureOf(LayerOf(edits, kLattice), {0, 0, 3, 1}), (Rows{"#--"}));
  edits[1].active = false;
  EXPECT_EQ(PictureOf(LayerOf(edits, kLattice), {0, 0, 3, 1}), (Rows{"###"}));
  edits[0].active = false;
  EXPECT_TRUE(LayerOf(edits, kLattice).empty());
}

TEST(History, EditsOfAnotherLatticeKeepTheirPlace) {
  std::vector<KeptEdit> edits = Drawn({"#.", ".#"});
  EXPECT_EQ(PictureOf(LayerOf(edits, {0.05, {-0.05, 0.0, 0.0}}), {0, 0, 4, 2}), (Rows{".#..", "..#."}));
  EXPECT_EQ(PictureOf(LayerOf(edits, {0.025, {}}), {0, 0, 4, 4}), (Rows{"##..", "##..", "..##", "..##"}));
}

std::vector<Conflict> ConflictsOf(const std::vector<Publication>& before, const std::vector<Publication>& since,
                                  const std::vector<KeptEdit>& draft) {
  std::vector<Publication> all = before;
  all.insert(all.end(), since.begin(), since.end());
  return FindConflicts(OverlayOf(before, kLattice), OverlayOf(all, kLattice), draft, since, kLattice);
}

TEST(Conflicts, AreCellsThatBothHaveChangedDifferently) {
  const auto conflicts = ConflictsOf({}, {Published(1, {"###---"}, "bob")}, Drawn({"#--.#-"}, "ann"));
  ASSERT_EQ(conflicts.size(), 2U);
  EXPECT_EQ(conflicts[0].region.box, (CellBox{1, 0, 2, 1}));
  EXPECT_EQ(conflicts[0].region.cells, 2);
  EXPECT_THAT(conflicts[0].mine, ElementsAre("ann"));
  EXPECT_THAT(conflicts[0].theirs, ElementsAre("bob"));
  EXPECT_EQ(conflicts[1].region.box, (CellBox{4, 0, 1, 1}));
}

TEST(Conflicts, AreNoneWhereOneAloneHasChangedACell) {
  const std::vector<Publication> before = {Published(1, {"##--??"})};
  EXPECT_THAT(ConflictsOf(before, {Published(2, {"-....x"})}, Drawn({".-.-?."})), IsEmpty());
  EXPECT_THAT(ConflictsOf(before, {}, Drawn({"------"})), IsEmpty());
  EXPECT_THAT(ConflictsOf({}, {Published(1, {"......"}), Published(2, {"####.."})}, Drawn({"....--"})), IsEmpty());
}

TEST(Conflicts, AreNoneWhereBothSayTheSame) {
  EXPECT_THAT(ConflictsOf({}, {Published(1, {"#-?"})}, Drawn({"#-?"})), IsEmpty());
  EXPECT_THAT(ConflictsOf({Published(1, {"###"})}, {Published(2, {"x.."})}, Drawn({"x.."})), IsEmpty());
  // Published and taken away again: as it was.
  EXPECT_THAT(ConflictsOf({}, {Published(1, {"#"}), Published(2, {"x"})}, Drawn({"-"})), IsEmpty());
}

TEST(Conflicts, TakingAnEditAwayIsSayingSomething) {
  const std::vector<Publication> before = {Published(1, {"##"})};
  EXPECT_EQ(ConflictsOf(before, {Published(2, {"-."})}, Drawn({"x."})).size(), 1U);
  EXPECT_EQ(ConflictsOf(before, {Published(2, {"x."})}, Drawn({"-."})).size(), 1U);
}

// The authors of what lies in the region itself, not of all that is in its box.
TEST(Conflicts, NameTheAuthorsOfTheirRegion) {
  const std::vector<KeptEdit> draft = Joined(Drawn({"-----",  //
                                                    "-....",  //
                                                    "-...."},
                                                   "ann"),
                                             Drawn({".....",  //
                                                    ".....",  //
                                                    "....-"},
                                                   "amy"));
  const std::vector<Publication> since = {Published(1,
                                                    {"#####",  //
                                                     "#....",  //
                                                     "#...."},
                                                    "bob"),
                                          Published(2,
                                                    {".....",  //
                                                     ".....",  //
                                                     "....#"},
                                                    "cid"),
                                          Published(3,
                                                    {".....",  //
                                                     "..#..",  //
                                                     "....."},
                                                    "dan")};
  const auto conflicts = ConflictsOf({}, since, draft);
  ASSERT_EQ(conflicts.size(), 2U);
  EXPECT_EQ(conflicts[0].region.box, (CellBox{0, 0, 5, 3}));
  EXPECT_THAT(conflicts[0].mine, ElementsAre("ann"));
  EXPECT_THAT(conflicts[0].theirs, ElementsAre("bob"));
  EXPECT_EQ(conflicts[1].region.box, (CellBox{4, 0, 1, 1}));
  EXPECT_THAT(conflicts[1].mine, ElementsAre("amy"));
  EXPECT_EQ(PictureOf(conflicts[0].cells, {0, 0, 5, 3}), (Rows{"#####", "#....", "#...."}));
  EXPECT_EQ(PictureOf(conflicts[1].cells, {0, 0, 5, 3}), (Rows{".....", ".....", "....#"}));
  EXPECT_THAT(conflicts[1].theirs, ElementsAre("cid"));
}

TEST(Conflicts, UndoneEditsHaveNone) {
  std::vector<KeptEdit> draft = Drawn({"--"});
  draft[0].active = false;
  EXPECT_THAT(ConflictsOf({}, {Published(1, {"##"})}, draft), IsEmpty());
}

// Against the definition, cell by cell.
TEST(Conflicts, AreExactlyTheCellsWhereNeitherMayWin) {
  std::mt19937 random(8);
  const RandomShapes shapes{{0, 0}, 4'000, 3'000};
  const auto any = [&](const std::string& author) {
    std::vector<KeptEdit> edits;
    for (int i = 0; i < 4; ++i) {
      edits.push_back(
          {"", author, i, random() % 5 != 0, kLattice, {RandomInstruction(random), shapes.RandomShape(random), false}});
    }
    return edits;
  };
  std::int64_t found = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const std::vector<Publication> before = {{1, "", any("a")}, {2, "", any("b")}};
    const std::vector<Publication> since = {{3, "", any("c")}};
    std::vector<Publication> all = {before[0], before[1], since[0]};
    const std::vector<KeptEdit> draft = any("d");
    const Overlay base = OverlayOf(before, kLattice), newest = OverlayOf(all, kLattice);
    const Overlay mine = LayerOf(draft, kLattice);
    std::int64_t expected = 0;
    for (int row = -60; row < 60; ++row) {
      for (int column = -60; column < 60; ++column) {
        const Instruction own = mine.At(column, row);
        if (own == Instruction::kNone) continue;
        const Instruction result = own == Instruction::kClear ? Instruction::kNone : own;
        const Instruction theirs = newest.At(column, row);
        expected += theirs != base.At(column, row) && theirs != result ? 1 : 0;
      }
    }
    std::int64_t cells = 0;
    for (const Conflict& conflict : ConflictsOf(before, since, draft)) {
      cells += conflict.region.cells;
      EXPECT_THAT(conflict.mine, ElementsAre("d"));
      EXPECT_THAT(conflict.theirs, ElementsAre("c"));
    }
    EXPECT_EQ(cells, expected) << trial;
    found += cells;
  }
  EXPECT_GT(found, 1000);
}

// What a session has seen, by letters as in OverlayIn.
Witness Seen(const Rows& picture, std::int64_t edit_version) {
  const Overlay cells = OverlayIn(picture);
  Witness witness{{0, 0, static_cast<int>(picture[0].size()), static_cast<int>(picture.size())}, {}, edit_version};
  for (int row = 0; row < witness.box.height; ++row) {
    for (int column = 0; column < witness.box.width; ++column) {
      const Instruction seen = cells.At(column, row);
      witness.classes.push_back(seen == Instruction::kFree
                                    ? CellClass::kFree
                                    : (seen == Instruction::kOccupied ? CellClass::kOccupied : CellClass::kUnknown));
    }
  }
  return witness;
}

TEST(Contests, AreEditsThatALaterSessionContradicts) {
  const std::vector<Publication> publications = {Published(1, {"------",  //
                                                               "......",  //
                                                               "####.."})};
  const auto contests = FindContests(publications, kLattice,
                                     Seen({"####--",  //
                                           "......",  //
                                           "----##"},
                                          1));
  ASSERT_EQ(contests.size(), 2U);
  EXPECT_EQ(contests[0].region.box, (CellBox{0, 0, 4, 1}));
  EXPECT_EQ(contests[0].edited, Instruction::kOccupied);
  EXPECT_EQ(contests[1].region.box, (CellBox{0, 2, 4, 1}));
  EXPECT_EQ(contests[1].region.cells, 4);
  EXPECT_EQ(contests[1].edited, Instruction::kFree);
  EXPECT_EQ(contests[1].edit_version, 1);
  EXPECT_THAT(contests[1].authors, ElementsAre("bob"));
  EXPECT_EQ(contests[1].message, "of bob");
}

TEST(Contests, NeedFourCellsThatTouch) {
  const std::vector<Publication> publications = {Published(1, {"-----", "-----"})};
  EXPECT_THAT(FindContests(publications, kLattice, Seen({"###..", "....#"}, 1)), IsEmpty());
  EXPECT_EQ(FindContests(publications, kLattice, Seen({"###..", "...#."}, 1)).size(), 1U);
}

TEST(Contests, AreNoneOfSessionsThatCameBeforeTheEdit) {
  const std::vector<Publication> publications = {Published(1, {"----...."}), Published(2, {"....----"})};
  EXPECT_THAT(FindContests(publications, kLattice, Seen({"########"}, 0)), IsEmpty());
  const auto contests = FindContests(publications, kLattice, Seen({"########"}, 1));
  ASSERT_EQ(contests.size(), 1U);
  EXPECT_EQ(contests[0].edit_version, 1);
  EXPECT_EQ(FindContests(publications, kLattice, Seen({"########"}, 2)).size(), 2U);  // one for each publication
}

// What people have said since settles it: keeping it, taking it away, or drawing something else.
TEST(Contests, AreNoneWhereALaterEditLies) {
  const Publication first = Published(1, {"----"});
  for (const Rows& later : {Rows{"----"}, Rows{"xxxx"}, Rows{"????"}, Rows{"####"}}) {
    EXPECT_THAT(FindContests({first, Published(2, later)}, kLattice, Seen({"####"}, 1)), IsEmpty()) << later[0];
  }
}

TEST(Contests, AreNoneOfUnknownCellsAndInvisibleThings) {
  EXPECT_THAT(FindContests({Published(1, {"????"})}, kLattice, Seen({"####"}, 1)), IsEmpty());
  EXPECT_THAT(FindContests({Published(1, {"????"})}, kLattice, Seen({"----"}, 1)), IsEmpty());
  EXPECT_THAT(FindContests({Published(1, {"----####"})}, kLattice, Seen({"........"}, 1)), IsEmpty());
  EXPECT_THAT(FindContests({Published(1, {"####"}, "bob", true)}, kLattice, Seen({"----"}, 1)), IsEmpty());
  EXPECT_EQ(FindContests({Published(1, {"----"}, "bob", true)}, kLattice, Seen({"####"}, 1)).size(), 1U);
}

TEST(Contests, NameTheAuthorsOfTheirRegion) {
  Publication publication = Published(1,
                                      {"----....",  //
                                       "-......."},
                                      "ann");
  publication.edits = Joined(publication.edits, Drawn({"........", "....----"}, "cid"));
  const auto contests = FindContests({publication}, kLattice,
                                     Seen({"####....",  //
                                           "#...####"},
                                          1));
  ASSERT_EQ(contests.size(), 1U);  // they touch at a corner
  EXPECT_THAT(contests[0].authors, ElementsAre("ann", "cid"));
  const auto apart = FindContests({publication}, kLattice,
                                  Seen({"###.....",  //
                                        "#...####"},
                                       1));
  ASSERT_EQ(apart.size(), 2U);
  EXPECT_THAT(apart[0].authors, ElementsAre("ann"));
  EXPECT_EQ(PictureOf(apart[0].cells, {0, 0, 8, 2}), (Rows{"###.....", "#......."}));
  EXPECT_EQ(PictureOf(apart[1].cells, {0, 0, 8, 2}), (Rows{"........", "....####"}));
  EXPECT_THAT(apart[1].authors, ElementsAre("cid"));
}

}  // namespace
}  // namespace enfilade::edit

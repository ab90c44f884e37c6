// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/edit/edit_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/support/status_assertions.h"

namespace enfilade::cli {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const edit::Lattice kMetricLattice{0.05, {}};

std::vector<std::pair<int, int>> PointsOf(const google::protobuf::RepeatedPtrField<v1::LatticePoint>& points) {
  std::vector<std::pair<int, int>> result;
  for (const v1::LatticePoint& point : points) result.emplace_back(point.x(), point.y());
  return result;
}

absl::StatusOr<v1::MapEdit> ReadOne(const std::string& edit, const edit::Lattice& lattice = kMetricLattice,
                                    const std::string& head = "") {
  auto edits = ReadEdits(head + "edits:\n- " + edit + "\n", lattice);
  if (!edits.ok()) return edits.status();
  EXPECT_EQ(edits->size(), 1U);
  return edits->front();
}

TEST(EditFile, MetresAreOfTheMapsFrame) {
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit brush,
                       ReadOne("{brush: [[0, 0], [1, -0.5]], radius: 0.1, value: occupied, invisible: true}"));
  EXPECT_THAT(PointsOf(brush.brush().points()), ElementsAre(std::pair(0, 0), std::pair(5120, -2560)));
  EXPECT_EQ(brush.brush().radius(), 512);
  EXPECT_EQ(brush.value(), v1::MapEdit::VALUE_OCCUPIED);
  EXPECT_TRUE(brush.invisible());
  // The lattice begins at (1, 2) and is turned by 90 degrees: its x axis goes along the map's y axis.
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit line,
                       ReadOne("{line: [[1, 2], [0, 4]], value: free}", {0.1, {1.0, 2.0, M_PI / 2}}));
  EXPECT_THAT(PointsOf(line.line().points()), ElementsAre(std::pair(0, 0), std::pair(5120, 2560)));
  EXPECT_FALSE(line.invisible());
}

TEST(EditFile, CellsAreTheirCentres) {
  const std::string cells = "unit: cells\n";
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit brush,
                       ReadOne("{brush: [[3, -5]], radius: 2, value: free}", {0.1, {7, 7, 1}}, cells));
  EXPECT_THAT(PointsOf(brush.brush().points()), ElementsAre(std::pair(896, -1152)));
  EXPECT_EQ(brush.brush().radius(), 512);
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit box,
                       ReadOne("{rectangle: [[0, 0], [2, 1]], value: clear}", kMetricLattice, cells));
  ASSERT_EQ(box.polygon().rings_size(), 1);
  EXPECT_THAT(PointsOf(box.polygon().rings(0).points()),
              ElementsAre(std::pair(128, 128), std::pair(640, 128), std::pair(640, 384), std::pair(128, 384)));
  EXPECT_EQ(box.value(), v1::MapEdit::VALUE_CLEAR);
}

TEST(EditFile, PolygonsHaveHoles) {
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit polygon,
                       ReadOne("{polygon: [[0, 0], [4, 0], [4, 3]], holes: [[[2, 0.5], [3, 0.5], [3, 1]]], value: "
                               "unknown, only_where: [free, occupied]}"));
  ASSERT_EQ(polygon.polygon().rings_size(), 2);
  EXPECT_EQ(polygon.polygon().rings(1).points_size(), 3);
  EXPECT_THAT(polygon.only_where(), ElementsAre(v1::MapEdit::VALUE_FREE, v1::MapEdit::VALUE_OCCUPIED));
}

TEST(EditFile, FillsHaveBoundsOrTheWholeMap) {
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit whole, ReadOne("{fill: [1, 2], value: free}"));
  EXPECT_EQ(whole.fill().seed().x(), 5120);
  EXPECT_EQ(whole.fill().seed().y(), 10240);
  EXPECT_EQ(whole.fill().bounds().width(), 1 << 22);
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit part,
                       ReadOne("{fill: [1, 2], bounds: [[2.02, 3.02], [0.02, -0.98]], value: free}"));
  const v1::CellBox& bounds = part.fill().bounds();
  EXPECT_EQ(bounds.first_column(), 0);
  EXPECT_EQ(bounds.first_row(), -20);
  EXPECT_EQ(bounds.width(), 41);
  EXPECT_EQ(bounds.height(), 81);
}

TEST(EditFile, PatchesArePictures) {
  ASSERT_OK_AND_ASSIGN(const v1::MapEdit patch,
                       ReadOne("{patch: [\"##.\", \"..#\", \"#.#\"], at: [-0.97, 1.02], value: occupied}"));
  EXPECT_EQ(patch.patch().box().first_column(), -20);
  EXPECT_EQ(patch.patch().box().first_row(), 20);
  EXPECT_EQ(patch.patch().box().width(), 3);
  EXPECT_EQ(patch.patch().box().height(), 3);
  EXPECT_THAT(patch.patch().runs(), ElementsAre(0U, 1U, 1U, 1U, 2U, 3U, 1U));
}

TEST(EditFile, ErrorsNameTheLineTheEditAndTheRemedy) {
  const auto expect = [](const std::string& edit, const ::testing::Matcher<std::string>& message) {
    EXPECT_STATUS(ReadOne(edit), absl::StatusCode::kInvalidArgument, message) << edit;
  };
  expect("{line: [[0, 0]]}", HasSubstr("line 2: edits[0].value is missing"));
  expect("{line: [[0, 0]], value: red}", AllOf(HasSubstr("\"red\""), HasSubstr("unknown, free, occupied, clear")));
  expect("{line: [[0, 0]], value: free, colour: 3}", HasSubstr("edits[0] has no key \"colour\""));
  expect("{line: [[0, 0]], value: free, radius: 3}", HasSubstr("no key \"radius\""));
  expect("{value: free}", HasSubstr("expected one of brush, line, polygon, rectangle, fill and patch"));
  expect("{line: [[0, 0]], fill: [0, 0], value: free}", HasSubstr("expected one of"));
  expect("{line: [[0, 0, 0]], value: free}", HasSubstr("edits[0].line: expected 2 numbers"));
  expect("{line: [[.nan, 0]], value: free}", HasSubstr("edits[0].line"));
  expect("{line: [[900000, 0]], value: free}", HasSubstr("2097152 cells from"));
  expect("{line: 7, value: free}", HasSubstr("list of points"));
  expect("{line: [], value: free}", HasSubstr("no points"));
  expect("{brush: [[0, 0]], value: free}", HasSubstr("radius is missing"));
  expect("{brush: [[0, 0]], radius: -1, value: free}", HasSubstr("radius is -1"));
  expect("{brush: [[0, 0]], radius: 13, value: free}", AllOf(HasSubstr("radius is 13"), HasSubstr("0 to 12.8")));
  expect("{rectangle: [[0, 0], [1, 1], [2, 2]], value: free}", HasSubstr("two opposite corners"));
  expect("{polygon: [[0, 0], [1, 1], [1, 0], [0, 1]], value: free}", HasSubstr("edits[0]: sides 1 and 3"));
  expect("{patch: [\"##\", \"#\"], at: [0, 0], value: free}", HasSubstr("rows of the same length"));
  expect("{patch: [\"#?\"], at: [0, 0], value: free}", HasSubstr("rows of the same length"));
  expect("{patch: [\"##\"], value: free}", HasSubstr("edits[0].at"));
  expect("{fill: [0, 0], value: free, only_where: [clear]}", HasSubstr("only_where has \"clear\""));
}

TEST(EditFile, FilesAreWholeOrRefused) {
  EXPECT_STATUS(ReadEdits("", kMetricLattice), absl::StatusCode::kInvalidArgument, HasSubstr("not a mapping"));
  EXPECT_STATUS(ReadEdits("edits: []", kMetricLattice), absl::StatusCode::kInvalidArgument, HasSubstr("no edits"));
  EXPECT_STATUS(ReadEdits("edits: 5", kMetricLattice), absl::StatusCode::kInvalidArgument, HasSubstr("not a list"));
  EXPECT_STATUS(ReadEdits("unit: ft\nedits: []", kMetricLattice), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("\"ft\""), HasSubstr("m, cells")));
  EXPECT_CODE(ReadEdits("edits: [", kMetricLattice), absl::StatusCode::kInvalidArgument);
  const std::string good = "- {line: [[0, 0]], value: free}\n";
  EXPECT_STATUS(ReadEdits("edits:\n" + good + good + "- {line: [[0, 0]]}\n", kMetricLattice),
                absl::StatusCode::kInvalidArgument, HasSubstr("line 4: edits[2].value"));
  ASSERT_OK_AND_ASSIGN(const auto edits, ReadEdits("author: Ann\nedits:\n" + good + good, kMetricLattice));
  ASSERT_EQ(edits.size(), 2U);
  EXPECT_EQ(edits[1].author(), "Ann");
}

TEST(EditFile, IdsStayTheSameWhenMoreIsAdded) {
  const auto ids_of = [](const std::string& draft, const std::vector<std::string>& lines) {
    std::string yaml = "edits:\n";
    for (const std::string& line : lines) yaml += "- {line: [[" + line + "]], value: free}\n";
    auto edits = ReadEdits(yaml, kMetricLattice);
    EXPECT_OK(edits);
    GiveIds(draft, *edits);
    std::vector<std::string> ids;
    for (const v1::MapEdit& edit : *edits) ids.push_back(edit.edit_id());
    return ids;
  };
  const auto first = ids_of("sites/s/maps/m/drafts/d", {"0, 0", "1, 1", "0, 0"});
  EXPECT_EQ(std::set<std::string>(first.begin(), first.end()).size(), 3U);
  EXPECT_THAT(first[0], ::testing::MatchesRegex("[0-9a-f]{8}-[0-9a-f]{4}-8[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}"));
  const auto more = ids_of("sites/s/maps/m/drafts/d", {"0, 0", "2, 2", "1, 1", "0, 0", "0, 0"});
  EXPECT_EQ(more[0], first[0]);
  EXPECT_EQ(more[2], first[1]);
  EXPECT_EQ(more[3], first[2]);
  EXPECT_NE(ids_of("sites/s/maps/m/drafts/e", {"0, 0"})[0], first[0]);
}

}  // namespace
}  // namespace enfilade::cli

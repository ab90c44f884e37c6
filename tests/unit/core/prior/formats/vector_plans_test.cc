// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/prior/formats/building_plan.h"
#include "core/prior/formats/dxf_plan.h"
#include "core/prior/formats/plan_lines.h"
#include "core/prior/formats/svg_plan.h"
#include "fmt/format.h"

namespace enfilade::prior {
namespace {

using ::testing::HasSubstr;

constexpr char kHeader[] = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n";

std::string Dxf(const std::string& entities, const std::string& blocks = "", const std::string& header = kHeader) {
  return header + "0\nSECTION\n2\nBLOCKS\n" + blocks + "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" + entities +
         "0\nENDSEC\n0\nEOF\n";
}

std::string DxfLine(const std::string& layer, double x1, double y1, double x2, double y2) {
  return fmt::format("0\nLINE\n8\n{}\n10\n{}\n20\n{}\n11\n{}\n21\n{}\n", layer, x1, y1, x2, y2);
}

TEST(DxfPlan, ReadsLinesAndPolylinesWithTheUnitAndTurnsYOver) {
  const auto plan = ReadDxfPlan(
      Dxf(DxfLine("A-WALL", 0, 0, 3000, 4000) +
          "0\nLWPOLYLINE\n8\nA-WALL\n90\n3\n70\n1\n43\n120\n10\n0\n20\n0\n10\n1000\n20\n0\n10\n1000\n20\n1000\n" +
          "0\nPOLYLINE\n8\nA-WALL\n70\n0\n0\nVERTEX\n10\n0\n20\n5\n0\nVERTEX\n10\n7\n20\n5\n0\nSEQEND\n"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_EQ(plan->graph.walls.size(), 5u);
  EXPECT_EQ(plan->graph.corners[1].point, Eigen::Vector2d(3000, -4000));
  EXPECT_EQ(plan->graph.walls[1].thickness, 120);
  EXPECT_EQ(plan->graph.metres_per_unit, 0.001);
  EXPECT_THAT(plan->warnings, ::testing::IsEmpty());
}

TEST(DxfPlan, DividesArcsAndBulgesIntoChords) {
  // Half a circle of 1 m, as an arc and as a bulge of 1: pi m each, less the chords' cutting of corners.
  for (const std::string& entity :
       {std::string("0\nARC\n8\n0\n10\n0\n20\n0\n40\n1000\n50\n0\n51\n180\n"),
        std::string("0\nLWPOLYLINE\n8\n0\n70\n0\n10\n1000\n20\n0\n42\n1\n10\n-1000\n20\n0\n42\n0\n")}) {
    const auto plan = ReadDxfPlan(Dxf(entity));
    ASSERT_TRUE(plan.ok()) << plan.status();
    EXPECT_NEAR(WallLength(plan->graph), 1000 * M_PI, 50);
    double highest = 0;
    for (const PlanCorner& corner : plan->graph.corners) {
      EXPECT_NEAR(corner.point.norm(), 1000, 1e-6);
      highest = std::min(highest, corner.point.y());
    }
    EXPECT_NEAR(highest, -1000, 30) << "above the x axis, so up in the sheet";
  }
}

TEST(DxfPlan, PlacesBlocks) {
  const std::string block = "0\nBLOCK\n2\nROOM\n" + DxfLine("0", 0, 0, 10, 0) + "0\nENDBLK\n";
  const std::string insert = "0\nINSERT\n8\nA-WALL\n2\nROOM\n10\n100\n20\n50\n41\n2\n42\n2\n50\n90\n";
  const auto plan = ReadDxfPlan(Dxf(insert, block), {"a-wall*"});
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_EQ(plan->graph.walls.size(), 1u) << "lines on layer 0 take the layer of the insertion";
  EXPECT_LT((plan->graph.corners[1].point - Eigen::Vector2d(100, -70)).norm(), 1e-9);
}

TEST(DxfPlan, ReadsChosenLayersOnly) {
  const auto plan = ReadDxfPlan(Dxf(DxfLine("A-WALL-EXT", 0, 0, 1, 0) + DxfLine("FURNITURE", 0, 0, 2, 0)), {"A-WALL*"});
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(WallLength(plan->graph), 1);
}

TEST(DxfPlan, WarnsIfThereIsNoUnit) {
  const auto plan = ReadDxfPlan(Dxf(DxfLine("0", 0, 0, 1, 0), "", ""));
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_FALSE(plan->graph.metres_per_unit.has_value());
  EXPECT_THAT(plan->warnings, ::testing::ElementsAre(HasSubstr("$INSUNITS")));
}

TEST(DxfPlan, RefusesBlocksThatContainThemselves) {
  const std::string insert = "0\nINSERT\n8\n0\n2\nLOOP\n";
  const auto plan = ReadDxfPlan(Dxf(insert, "0\nBLOCK\n2\nLOOP\n" + insert + "0\nENDBLK\n"));
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr("block \"LOOP\""));
}

TEST(DxfPlan, RefusesBlocksThatMultiply) {
  std::string blocks, insert;
  for (int i = 0; i < 7; ++i) {  // 20^7 lines
    blocks += fmt::format("0\nBLOCK\n2\nB{}\n", i) + (i == 0 ? DxfLine("0", 0, 0, 1, 0) : insert) + "0\nENDBLK\n";
    insert.clear();
    for (int k = 0; k < 20; ++k) insert += fmt::format("0\nINSERT\n8\n0\n2\nB{}\n10\n{}\n", i, k);
  }
  EXPECT_EQ(ReadDxfPlan(Dxf(insert, blocks)).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(DxfPlan, RefusesBlocksThatHoldMuchButNoLines) {
  std::string block = "0\nBLOCK\n2\nB\n", inserts;
  for (int i = 0; i < 20'000; ++i) block += "0\nTEXT\n8\n0\n1\nx\n";
  for (int i = 0; i < 20'000; ++i) inserts += "0\nINSERT\n8\n0\n2\nB\n";
  const auto plan = ReadDxfPlan(Dxf(inserts, block + "0\nENDBLK\n"));
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr("inserted blocks"));
}

TEST(DxfPlan, RefusesMoreThanAMillionLines) {
  std::string block = "0\nBLOCK\n2\nB\n", inserts;
  for (int i = 0; i < 20'000; ++i) block += DxfLine("0", i, 0, i, 1);
  for (int i = 0; i < 51; ++i) inserts += "0\nINSERT\n8\n0\n2\nB\n";
  const auto plan = ReadDxfPlan(Dxf(inserts, block + "0\nENDBLK\n"));
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr("1000000 lines"));
  std::string bulges = "0\nLWPOLYLINE\n8\n0\n70\n0\n";
  for (int i = 0; i < 30'000; ++i) bulges += fmt::format("10\n{}\n20\n0\n42\n1\n", 1e9 * (i % 2));
  EXPECT_EQ(ReadDxfPlan(Dxf(bulges)).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(DxfPlan, LeavesOutNumbersThatAreNone) {
  const auto plan = ReadDxfPlan(Dxf("0\nLINE\n8\n0\n10\nnan\n20\ninf\n11\n3\n21\n1e999\n"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(WallLength(plan->graph), 3) << "they count as 0";
  const auto far = ReadDxfPlan(Dxf(DxfLine("0", 0, 0, 1e300, 0)));
  EXPECT_EQ(far.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(far.status().message()), HasSubstr("1e12"));
}

TEST(DxfPlan, NamesTheLineWhereAFileIsDamaged) {
  const auto truncated = ReadDxfPlan("0\nSECTION\n2\nENTITIES\n0\nLINE\nten\n5\n");
  EXPECT_EQ(truncated.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(truncated.status().message()), HasSubstr("line 7"));
  EXPECT_EQ(ReadDxfPlan("0\nEOF\n").status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadDxfPlan("AutoCAD Binary DXF\r\n").status().code(), absl::StatusCode::kInvalidArgument);
}

std::string Svg(const std::string& body) {
  return R"(<svg xmlns="http://www.w3.org/2000/svg" width="100" height="80">)" + body + "</svg>";
}

TEST(SvgPlan, ReadsEveryShapeOfLines) {
  const auto plan = ReadSvgPlan(Svg(R"(<line x1="0" y1="0" x2="3" y2="4"/><polyline points="0,0 10,0 10,5"/>
    <polygon points="0 0 1 0 1 1"/><rect x="1" y="2" width="3" height="4"/>
    <path d="M0 0h4v3z m10,0 l-1-1 L20 5"/>)"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->graph.walls.size(), 1u + 2 + 3 + 4 + 3 + 2);
  EXPECT_NEAR(LengthOf(plan->graph, plan->graph.walls[0]), 5, 1e-12);
}

TEST(SvgPlan, ComposesTransformsAndScalesThickness) {
  const auto plan = ReadSvgPlan(Svg(R"svg(<g transform="translate(10 20) scale(2)" style="stroke-width:3">
    <g transform="rotate(90)"><line x1="0" y1="0" x2="5" y2="0"/></g></g>
    <line transform="matrix(1 0 0 -1 0 50)" x1="1" y1="2" x2="1" y2="8"/>)svg"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_EQ(plan->graph.walls.size(), 2u);
  EXPECT_LT((plan->graph.corners[1].point - Eigen::Vector2d(10, 30)).norm(), 1e-9);
  EXPECT_NEAR(plan->graph.walls[0].thickness, 6, 1e-12);
  EXPECT_LT((plan->graph.corners[2].point - Eigen::Vector2d(1, 48)).norm(), 1e-9);
}

TEST(SvgPlan, CurvesEndWhereTheyShould) {
  const auto plan =
      ReadSvgPlan(Svg(R"(<path d="M10 0 A10 10 0 0 1 -10 0"/><path d="M0 0 C0 5 10 5 10 0 S20-5 20 0"/>)"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  double lowest = 0;
  for (const PlanWall& wall : plan->graph.walls) lowest = std::max(lowest, plan->graph.corners[wall.to].point.y());
  EXPECT_NEAR(lowest, 10, 0.1) << "clockwise on a sheet whose y points down";
  EXPECT_LT((plan->graph.corners.back().point - Eigen::Vector2d(20, 0)).norm(), 1e-9);
}

TEST(SvgPlan, LeavesOutWhatIsHiddenDashedOrOfOtherLayers) {
  const std::string body = R"(<defs><line x1="0" y1="0" x2="9" y2="0"/></defs>
    <g id="Walls"><line x1="0" y1="0" x2="1" y2="0"/><line style="display:none" x1="0" y1="0" x2="2" y2="0"/></g>
    <g id="grid"><line stroke-dasharray="2 2" x1="0" y1="0" x2="4" y2="0"/><line x1="0" y1="0" x2="8" y2="0"/></g>)";
  EXPECT_EQ(WallLength(ReadSvgPlan(Svg(body))->graph), 1 + 8);
  EXPECT_EQ(WallLength(ReadSvgPlan(Svg(body), {"wall?"})->graph), 1);
}

TEST(SvgPlan, UsesElementsOfTheSameFileOnly) {
  const auto plan = ReadSvgPlan(Svg(R"(<defs><line id="w" x1="0" y1="0" x2="5" y2="0"/></defs>
    <use href="#w" x="10" y="2"/><use href="file:///etc/passwd#w"/><image href="http://example.org/a.png"/>
    <script>alert(1)</script>)"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_EQ(plan->graph.walls.size(), 1u);
  EXPECT_EQ(plan->graph.corners[0].point, Eigen::Vector2d(10, 2));
  EXPECT_THAT(plan->warnings, ::testing::UnorderedElementsAre(HasSubstr("image"), HasSubstr("script"),
                                                              HasSubstr("references to other files")));
}

TEST(SvgPlan, ExpandsNoEntities) {
  const auto plan = ReadSvgPlan(
      R"(<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;"><!ENTITY x SYSTEM "file:///etc/passwd">]>)" +
      Svg(R"(<text>&b;&x;</text><line x1="0" y1="0" x2="1" y2="0"/>)"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->graph.walls.size(), 1u);
}

TEST(SvgPlan, RefusesWhatUsesMultiply) {
  std::string path, uses;
  for (int i = 0; i < 20'000; ++i) path += "M0 0 ";  // no line at all
  for (int i = 0; i < 20'000; ++i) uses += R"(<use href="#p"/>)";
  const auto moves = ReadSvgPlan(Svg("<defs><path id=\"p\" d=\"" + path + "\"/></defs>" + uses));
  EXPECT_EQ(moves.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(moves.status().message()), HasSubstr("SVG elements"));
  std::string bomb = R"(<g id="u0"><line x1="0" y1="0" x2="1" y2="0"/></g>)";
  for (int i = 0; i < 7; ++i) {  // 10^7 lines
    bomb += fmt::format("<g id=\"u{}\">", i + 1);
    for (int k = 0; k < 10; ++k) bomb += fmt::format("<use href=\"#u{}\"/>", i);
    bomb += "</g>";
  }
  const auto lines = ReadSvgPlan(Svg("<defs>" + bomb + "</defs><use href=\"#u7\"/>"));
  EXPECT_EQ(lines.status().code(), absl::StatusCode::kResourceExhausted) << lines.status();
}

TEST(SvgPlan, RefusesMoreThanAMillionLines) {
  std::string points = "0 0";
  for (int i = 0; i < 500'001; ++i) points += " 1 1 0 0";
  const auto plan = ReadSvgPlan(Svg("<polyline points=\"" + points + "\"/>"));
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr("1000000 lines"));
}

TEST(SvgPlan, RefusesUsesWithinThemselvesAndDamagedFiles) {
  EXPECT_EQ(ReadSvgPlan(Svg(R"(<g id="g"><use href="#g"/></g>)")).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadSvgPlan("<svg><g></svg>").status().code(), absl::StatusCode::kInvalidArgument);
  std::string deep, closed;
  for (int i = 0; i < 300'000; ++i) deep += "<g>", closed += "</g>";
  EXPECT_EQ(ReadSvgPlan(Svg(deep + closed)).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadSvgPlan("<html/>").status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(IsWantedLayer, MatchesPatterns) {
  EXPECT_TRUE(IsWantedLayer({}, "any"));
  EXPECT_TRUE(IsWantedLayer({"x", "A-*-?xt"}, "a-wall-EXT"));
  EXPECT_FALSE(IsWantedLayer({"A-WALL"}, "A-WALL-EXT"));
  EXPECT_FALSE(IsWantedLayer({"*a*a*a*a*b"}, std::string(10'000, 'a')));
}

TEST(BuildingPlan, HasTheWallsDoorsAndLiftsOfALevelInPixels) {
  const auto building = ParseBuilding(R"(name: house
levels:
  Ground:
    elevation: 0
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[100, 100, 0, ""], [300, 100, 0, ""], [300, 200, 0, ""], [100, 200, 0, ""]]
    walls: [[0, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}]]
    doors: [[1, 2, {name: [1, "d"], type: [1, hinged]}]]
lifts:
  L: {reference_floor_name: Ground, x: 200, y: 150, yaw: 0, width: 2, depth: 1, level_doors: {Ground: [d]}, doors: {}}
)");
  ASSERT_TRUE(building.ok()) << building.status();
  const PlanGraph plan = PlanOfLevel(*building, 0);
  ASSERT_EQ(plan.walls.size(), 4u);
  EXPECT_NEAR(*plan.metres_per_unit, 0.05, 1e-12);
  EXPECT_LT((plan.corners[plan.walls[1].to].point - Eigen::Vector2d(300, 200)).norm(), 1e-9);
  ASSERT_EQ(plan.doors.size(), 1u);
  EXPECT_NEAR((plan.doors[0].to - plan.doors[0].from).norm(), 100, 1e-9);
  EXPECT_LT(((plan.doors[0].to + plan.doors[0].from) / 2 - Eigen::Vector2d(300, 150)).norm(), 1e-9);
  ASSERT_EQ(plan.shafts.size(), 1u);
  EXPECT_LT((plan.shafts[0].outline[0] - Eigen::Vector2d(180, 160)).norm(), 1e-9);
}

}  // namespace
}  // namespace enfilade::prior

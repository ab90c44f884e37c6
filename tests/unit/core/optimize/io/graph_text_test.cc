// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/io/graph_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/manhattan_graph.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using testing::PoseNear;

TEST(ParsePoseGraph, ReadsG2o) {
  ASSERT_OK_AND_ASSIGN(const ParsedPoseGraph parsed, ParsePoseGraph("# a comment\n"
                                                                    "VERTEX_SE2 7 1 -2.5 0.5\r\n"
                                                                    "\n"
                                                                    "  VERTEX_SE2\t-3 +4e-1 5 6 # the second\n"
                                                                    "FIX 7\n"
                                                                    "EDGE_SE2 7 -3 1 2 3 10 1 2 20 3 30",
                                                                    "a.g2o"));
  EXPECT_EQ(parsed.format, GraphFormat::kG2o);
  EXPECT_THAT(parsed.fixed, ElementsAre(7));
  ASSERT_EQ(parsed.graph.nodes.size(), 2u);
  EXPECT_EQ(parsed.graph.nodes[1].id, -3);
  EXPECT_EQ(parsed.graph.nodes[1].T_world_node, (Pose2{0.4, 5.0, 6.0}));
  ASSERT_EQ(parsed.graph.edges.size(), 1u);
  const Eigen::Matrix3d expected = (Eigen::Matrix3d() << 10, 1, 2, 1, 20, 3, 2, 3, 30).finished();
  EXPECT_EQ(parsed.graph.edges[0].information, expected);
  EXPECT_EQ(parsed.graph.edges[0].T_from_to, (Pose2{1, 2, 3}));
}

// TORO's order is I11 I12 I22 I33 I13 I23.
TEST(ParsePoseGraph, ReadsToro) {
  ASSERT_OK_AND_ASSIGN(const ParsedPoseGraph parsed,
                       ParsePoseGraph("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 10 1 20 30 2 3\n", "a.graph"));
  EXPECT_EQ(parsed.format, GraphFormat::kToro);
  const Eigen::Matrix3d expected = (Eigen::Matrix3d() << 10, 1, 2, 1, 20, 3, 2, 3, 30).finished();
  EXPECT_EQ(parsed.graph.edges.at(0).information, expected);
}

TEST(ParsePoseGraph, CountsTagsItDoesNotUnderstand) {
  ASSERT_OK_AND_ASSIGN(
      const ParsedPoseGraph parsed,
      ParsePoseGraph("VERTEX_SE2 0 0 0 0\nVERTEX_XY 5 1 1\nPARAMS_SE2OFFSET 0 0 0 0\nVERTEX_XY 6 1 1\n", "a.g2o"));
  EXPECT_THAT(parsed.skipped, ElementsAre(Pair("PARAMS_SE2OFFSET", 1), Pair("VERTEX_XY", 2)));
}

TEST(ParsePoseGraph, AcceptsNothing) {
  ASSERT_OK_AND_ASSIGN(const ParsedPoseGraph parsed, ParsePoseGraph("# empty\n\n", "a.g2o"));
  EXPECT_TRUE(parsed.graph.nodes.empty());
  EXPECT_FALSE(parsed.poses_from_edges);
}

TEST(ParsePoseGraph, PosesNodesAlongEdgesWhereNoneIsDeclared) {
  ASSERT_OK_AND_ASSIGN(const ParsedPoseGraph parsed, ParsePoseGraph("EDGE_SE2 4 2 1 0 1.5707963267948966 1 0 0 1 0 1\n"
                                                                    "EDGE_SE2 4 9 0 2 0 1 0 0 1 0 1\n",
                                                                    "a.g2o"));
  EXPECT_TRUE(parsed.poses_from_edges);
  ASSERT_EQ(parsed.graph.nodes.size(), 3u);
  EXPECT_EQ(parsed.graph.nodes[0].id, 2);
  EXPECT_THAT(parsed.graph.nodes[0].T_world_node, PoseNear(Pose2{}, 0.0, 0.0));
  EXPECT_THAT(parsed.graph.nodes[1].T_world_node, PoseNear(Pose2{0, 1, -M_PI_2}, 1e-12, 1e-12));
  EXPECT_THAT(parsed.graph.nodes[2].T_world_node, PoseNear(Pose2{2, 1, -M_PI_2}, 1e-12, 1e-12));
}

struct BadText {
  const char* name;
  const char* text;
  const char* where;
  const char* what;
};

class ParsePoseGraphRejects : public ::testing::TestWithParam<BadText> {};

TEST_P(ParsePoseGraphRejects, NamingTheLine) {
  EXPECT_STATUS(ParsePoseGraph(GetParam().text, "a.g2o"), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr(GetParam().where), HasSubstr(GetParam().what)));
}

INSTANTIATE_TEST_SUITE_P(
    Texts, ParsePoseGraphRejects,
    ::testing::Values(
        BadText{"AbsentNode", "VERTEX_SE2 0 0 0 0\n\nEDGE_SE2 0 8 1 0 0 1 0 0 1 0 1\n", "a.g2o:3", "node 8"},
        BadText{"AbsentFixedNode", "FIX 3\nVERTEX_SE2 0 0 0 0\n", "a.g2o:1", "node 3"},
        BadText{"FixWithoutNode", "VERTEX_SE2 0 0 0 0\nFIX\n", "a.g2o:2", "FIX without a node id"},
        BadText{"TwoOfTheSame", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 1 0 0\n", "a.g2o:2", "second time"},
        BadText{"SelfLoop", "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 0 1 0 0 1 0 0 1 0 1\n", "a.g2o:2", "itself"},
        BadText{"NotPositiveDefinite", "EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\n", "a.g2o:1", "not positive definite"},
        BadText{"Semidefinite", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n", "a.g2o:1", "not positive definite"},
        BadText{"NotANumber", "VERTEX_SE2 0 0 nan 0\n", "a.g2o:1", "'nan'"},
        BadText{"Infinite", "EDGE_SE2 0 1 1 0 0 inf 0 0 1 0 1\n", "a.g2o:1", "'inf'"},
        BadText{"Letters", "VERTEX_SE2 0 0 1x 0\n", "a.g2o:1", "'1x'"},
        BadText{"IdNotAnInteger", "VERTEX_SE2 0.5 0 1 0\n", "a.g2o:1", "'0.5'"},
        BadText{"IdTooLarge", "VERTEX_SE2 99999999999999999999 0 1 0\n", "a.g2o:1", "'99999999999999999999'"},
        BadText{"TooFewFields", "VERTEX_SE2 0 0 0\n", "a.g2o:1", "3 fields, not 4"},
        BadText{"TooManyFields", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1 1\n", "a.g2o:1", "12 fields, not 11"},
        BadText{"ThreeDimensions", "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", "a.g2o:1", "3D"},
        BadText{"SomethingElse", "\nhello world\n", "a.g2o:2", "hello"}),
    [](const ::testing::TestParamInfo<BadText>& text) { return std::string(text.param.name); });

TEST(WritePoseGraph, IsReadBackExactly) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 50}).graph;
  graph.nodes[3].T_world_node = {1e-300, -1.0 / 3.0, 1e17};
  for (const GraphFormat format : {GraphFormat::kG2o, GraphFormat::kToro}) {
    ASSERT_OK_AND_ASSIGN(const ParsedPoseGraph parsed, ParsePoseGraph(WritePoseGraph(graph, format, {7, 9}), "back"));
    EXPECT_EQ(parsed.format, format);
    EXPECT_EQ(parsed.fixed.size(), format == GraphFormat::kG2o ? 2u : 0u);
    ASSERT_EQ(parsed.graph.nodes.size(), graph.nodes.size());
    ASSERT_EQ(parsed.graph.edges.size(), graph.edges.size());
    for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
      EXPECT_EQ(parsed.graph.nodes[i].id, graph.nodes[i].id);
      EXPECT_EQ(parsed.graph.nodes[i].T_world_node, graph.nodes[i].T_world_node);
    }
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {
      EXPECT_EQ(parsed.graph.edges[k].from, graph.edges[k].from);
      EXPECT_EQ(parsed.graph.edges[k].to, graph.edges[k].to);
      EXPECT_EQ(parsed.graph.edges[k].T_from_to, graph.edges[k].T_from_to);
      const Eigen::Matrix3d& written = graph.edges[k].information;  // its upper triangle
      EXPECT_EQ(parsed.graph.edges[k].information, Eigen::Matrix3d(written.selfadjointView<Eigen::Upper>()));
    }
  }
}

TEST(WritePoseGraph, LeavesOutDisabledEdges) {
  PoseGraph graph = testing::MakeManhattanGraph({.nodes = 5}).graph;
  const std::size_t edges = graph.edges.size();
  graph.edges[1].enabled = false;
  ASSERT_OK_AND_ASSIGN(const ParsedPoseGraph parsed, ParsePoseGraph(WritePoseGraph(graph, GraphFormat::kG2o), "back"));
  EXPECT_EQ(parsed.graph.edges.size(), edges - 1);
}

}  // namespace
}  // namespace enfilade::optimize

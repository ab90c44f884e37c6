// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "client/cli/commands/commands.h"
#include "core/optimize/io/graph_text.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/cli/command_test.h"

namespace enfilade::cli {
namespace {

using ::testing::HasSubstr;

class GraphSolveTest : public CommandTest {
 protected:
  absl::Status Run(std::vector<std::string> arguments, bool json = true) {
    arguments.insert(arguments.begin(), {"graph", "solve"});
    const auto add = [](CLI::App& app, const Globals& globals) {
      AddGraphSolve(*app.add_subcommand("graph"), globals);
    };
    return RunCommandLine(add, std::move(arguments), json);
  }

  const optimize::PoseGraph graph_ = testing::MakeManhattanGraph({.nodes = 100}).graph;
};

TEST_F(GraphSolveTest, PrintsWhatProgramsAskFor) {
  const std::string path =
      File("a.g2o", optimize::WritePoseGraph(graph_, optimize::GraphFormat::kG2o) + "VERTEX_XY 5000 1 1\n");
  ASSERT_OK(Run({path, "--covariance", "99"}));
  const nlohmann::json document = nlohmann::json::parse(printed_);
  EXPECT_GT(document["initial_chi2"], document["final_chi2"]);
  EXPECT_GT(document["iterations"], 0);
  EXPECT_GT(document["seconds"], 0.0);
  EXPECT_EQ(document["components"], 1);
  EXPECT_EQ(document["converged"], true);
  EXPECT_EQ(document["skipped"]["VERTEX_XY"], 1);
  EXPECT_EQ(document["covariances"][0]["node"], 99);
  EXPECT_GT(document["covariances"][0]["covariance"][2][2], 0.0);
}

TEST_F(GraphSolveTest, ReportsToPeopleComponentsAndUnknownTags) {
  const std::string path = File(
      "a.g2o", optimize::WritePoseGraph(graph_, optimize::GraphFormat::kG2o) + "VERTEX_SE2 5000 1 1 0\nPARAMS_X 1\n");
  ASSERT_OK(Run({path}, false));
  EXPECT_THAT(printed_, HasSubstr("2 components"));
  EXPECT_THAT(printed_, HasSubstr("skipped 1 line of the unknown tag PARAMS_X"));
  EXPECT_THAT(printed_, HasSubstr("initial chi2"));
}

TEST_F(GraphSolveTest, WritesTheSolutionInTheFormOfItsName) {
  const std::string path = File("a.g2o", optimize::WritePoseGraph(graph_, optimize::GraphFormat::kG2o, {3}));
  for (const auto& [name, format] :
       {std::pair{"b.graph", optimize::GraphFormat::kToro}, std::pair{"b.g2o", optimize::GraphFormat::kG2o},
        std::pair{"b.txt", optimize::GraphFormat::kG2o}}) {
    const std::string output = directory_.path() / name;
    ASSERT_OK(Run({path, "-o", output}));
    const double final_chi2 = nlohmann::json::parse(printed_)["final_chi2"];
    ASSERT_OK_AND_ASSIGN(const optimize::ParsedPoseGraph solved, optimize::ParsePoseGraph(Content(output), name));
    EXPECT_EQ(solved.format, format);
    EXPECT_EQ(solved.graph.nodes[3].T_world_node, graph_.nodes[3].T_world_node) << "FIX is honoured";
    ASSERT_OK(Run({output, "--init", "none"}));
    EXPECT_NEAR(nlohmann::json::parse(printed_)["initial_chi2"], final_chi2, 1e-9 * final_chi2);
  }
}

TEST_F(GraphSolveTest, AppliesTheKernelToLoopsOnlyWhereOdometryIsTrusted) {
  optimize::PoseGraph graph = graph_;
  graph.edges.push_back({10, 90, {5.0, 5.0, 1.0}, graph.edges.front().information});
  const std::string path = File("a.g2o", optimize::WritePoseGraph(graph, optimize::GraphFormat::kG2o));
  ASSERT_OK(Run({path}));
  const double misled = nlohmann::json::parse(printed_)["final_cost"];
  ASSERT_OK(Run({path, "--robust", "dcs", "--kernel-width", "2", "--trust-odometry"}));
  const nlohmann::json robust = nlohmann::json::parse(printed_);
  EXPECT_LT(robust["final_cost"], 0.5 * misled);
  EXPECT_GT(robust["final_chi2"], robust["final_cost"]);
}

TEST_F(GraphSolveTest, SaysWhichFileAndLineIsWrong) {
  EXPECT_STATUS(Run({directory_.path() / "absent.g2o"}), absl::StatusCode::kNotFound, HasSubstr("absent.g2o"));
  EXPECT_STATUS(Run({directory_.path()}), absl::StatusCode::kInvalidArgument, HasSubstr("folder"));
  EXPECT_STATUS(Run({File("bad.g2o", "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n")}),
                absl::StatusCode::kInvalidArgument, HasSubstr("bad.g2o:2"));
  const std::string good = File("a.g2o", optimize::WritePoseGraph(graph_, optimize::GraphFormat::kG2o));
  EXPECT_STATUS(Run({good, "-o", directory_.path() / "absent" / "b.g2o"}), absl::StatusCode::kFailedPrecondition,
                HasSubstr("cannot be written"));
  EXPECT_STATUS(Run({good, "--robust", "tukey"}), absl::StatusCode::kInvalidArgument, HasSubstr("tukey"));
  EXPECT_STATUS(Run({good, "--kernel-width", "0"}), absl::StatusCode::kInvalidArgument, HasSubstr("width"));
}

TEST_F(GraphSolveTest, AcceptsAnEmptyFile) {
  ASSERT_OK(Run({File("empty.g2o", "")}));
  EXPECT_EQ(nlohmann::json::parse(printed_)["components"], 0);
}

}  // namespace
}  // namespace enfilade::cli

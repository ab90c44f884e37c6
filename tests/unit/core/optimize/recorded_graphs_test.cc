// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "core/optimize/io/graph_text.h"
#include "core/optimize/solve_pose_graph.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::optimize {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Content(const std::filesystem::path& path) {
  std::stringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

class RecordedGraphsTest : public ::testing::TestWithParam<std::string> {};

// Within 1e-6 of the known optimum, from the file's own guess; where that is all but zero, absolutely.
TEST_P(RecordedGraphsTest, ReachesTheKnownOptimum) {
  ENFILADE_RECORDING_OR_SKIP(path, GetParam());
  ENFILADE_RECORDING_OR_SKIP(optimum_path, "posegraph/optimum.json");
  const nlohmann::json known = nlohmann::json::parse(Content(optimum_path))["graphs"][GetParam()];
  ASSERT_OK_AND_ASSIGN(ParsedPoseGraph parsed, ParsePoseGraph(Content(path), GetParam()));
  EXPECT_EQ(parsed.graph.nodes.size(), known["poses"]);
  EXPECT_EQ(parsed.graph.edges.size(), known["edges"]);
  EXPECT_EQ(parsed.poses_from_edges, known["vertices"] == 0);

  ASSERT_OK_AND_ASSIGN(const SolveReport report, SolvePoseGraph({.fixed = parsed.fixed}, parsed.graph));
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.components, known["components"]);
  if (known.contains("chi2_file_init")) {
    const double initial = known["chi2_file_init"];
    EXPECT_NEAR(report.initial_chi2, initial, 1e-6 * initial);
  }
  const double optimum = known["chi2_opt"];
  EXPECT_NEAR(report.final_chi2, optimum, std::max(1e-6 * optimum, 1e-9));
}

INSTANTIATE_TEST_SUITE_P(
    Graphs, RecordedGraphsTest,
    ::testing::Values("posegraph/sesync/intel.g2o", "posegraph/sesync/manhattan.g2o",
                      "posegraph/carlone/input_INTEL_g2o.g2o", "posegraph/carlone/input_M3500_g2o.g2o",
                      "posegraph/vertigo/intel_originalDataset_intel.g2o",
                      "posegraph/vertigo/manhattan_originalDataset_g2o_manhattanOlson3500.g2o",
                      "posegraph/vertigo/ring_groundTruth_ring.g2o", "posegraph/vertigo/ring_originalDataset_ring.g2o",
                      "laser/flirtlib/intel-lab.log"),
    [](const ::testing::TestParamInfo<std::string>& graph) {
      std::string name = graph.param;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
      return name;
    });

TEST(RecordedGraphs, ThreeDimensionalOnesAreRefused) {
  ENFILADE_RECORDING_OR_SKIP(path, "posegraph/sesync/smallGrid3D.g2o");
  EXPECT_STATUS(ParsePoseGraph(Content(path), "smallGrid3D.g2o"), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("smallGrid3D.g2o:1"), HasSubstr("3D")));
}

}  // namespace
}  // namespace enfilade::optimize

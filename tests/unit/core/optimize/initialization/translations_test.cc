// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/translations.h"

#include <gtest/gtest.h>

#include "core/optimize/linear/normal_equations.h"
#include "tests/support/manhattan_graph.h"
#include "tests/support/status_assertions.h"

namespace enfilade::optimize {
namespace {

class SolveTranslationsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_OK_AND_ASSIGN(std::vector<IndexedGraph> components,
                         IndexComponents(testing::MakeManhattanGraph({.nodes = 80}).graph, {0, 40}));
    graph_ = std::move(components.front());
    layout_ = LayOut(graph_);
  }

  // The derivatives by all x and y.
  double TranslationGradient(const std::vector<Pose2>& poses) {
    graph_.poses = poses;
    NormalEquations equations;
    Linearize(graph_, layout_, {}, equations);
    double largest = 0.0;
    for (int k = 0; k < layout_.structure.size; ++k) {
      largest = std::max(largest, equations.b.segment<2>(3 * k).cwiseAbs().maxCoeff());
    }
    return largest;
  }

  IndexedGraph graph_;
  GraphLayout layout_;
};

TEST_F(SolveTranslationsTest, EndsWhereNoTranslationLowersTheCost) {
  std::vector<Pose2> poses = graph_.poses;
  const double before = TranslationGradient(poses);
  ASSERT_TRUE(SolveTranslations(graph_, layout_, {}, poses, poses));
  EXPECT_LT(TranslationGradient(poses), 1e-9 * before);
}

TEST_F(SolveTranslationsTest, KeepsYawsAndHeldNodes) {
  std::vector<Pose2> poses = graph_.poses;
  ASSERT_TRUE(SolveTranslations(graph_, layout_, {}, poses, poses));
  for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_EQ(poses[i].yaw, graph_.poses[i].yaw);
  EXPECT_EQ(poses[0], graph_.poses[0]);
  EXPECT_EQ(poses[40], graph_.poses[40]);
  EXPECT_NE(poses[20].x, graph_.poses[20].x);
}

}  // namespace
}  // namespace enfilade::optimize

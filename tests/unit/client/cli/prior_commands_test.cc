// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "client/cli/commands/commands.h"
#include "core/geometry/pose2.h"
#include "fmt/format.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/cli/command_test.h"

namespace enfilade::cli {
namespace {

using ::testing::HasSubstr;

// A simulated building, its plan as people would draw it, and what two robots recorded there.
class PriorCommandsTest : public CommandTest {
 protected:
  absl::Status Run(std::vector<std::string> arguments) {
    const auto add = [](CLI::App& app, const Globals& globals) {
      AddSimulate(app, globals);
      AddPrior(app, globals);
    };
    return RunCommandLine(add, std::move(arguments), true);
  }
  std::string Path(const std::string& name) const { return directory_.path() / name; }
  void Simulate() {
    ASSERT_OK(
        Run({"simulate", "random:402", "-o", Path("campus"), "--plan-out", Path("plan"), "--plan-deform", "402"}));
  }
  // Where a robot was switched on, which is the origin of its map.
  Pose2 StartOf(const std::string& robot) const {
    std::istringstream line(Content(Path("campus/" + robot + "/truth.txt")));
    double time = 0;
    Pose2 pose;
    line >> time >> pose.x >> pose.y >> pose.yaw;
    return pose;
  }
  nlohmann::json Printed() const { return nlohmann::json::parse(printed_); }
};

TEST_F(PriorCommandsTest, FitJoinsTheLogsOfTwoRobotsByAPicture) {
  Simulate();
  const std::string points = File("points.csv", "100,100\n");
  ASSERT_OK(Run({"prior", "fit", Path("plan/plan-filled.png"), Path("campus/robot/log.jsonl"),
                 Path("campus/robot2/log.jsonl"), "--points", points, "-o", Path("out")}));
  const nlohmann::json report = Printed();
  EXPECT_EQ(report["accepted"], true) << report["reason"];
  EXPECT_EQ(report["mode"], "full");
  ASSERT_EQ(report["inputs"].size(), 2U);
  EXPECT_TRUE(report["inputs"][1].contains("T_first_input")) << report["inputs"][1]["reason"];
  const std::vector<double> place = report["inputs"][1]["T_first_input"];
  const Pose2 error = Between(Between(StartOf("robot"), StartOf("robot2")), Pose2{place[0], place[1], place[2]});
  EXPECT_LT(error.translation().norm(), 0.1);
  EXPECT_LT(std::abs(error.yaw), 0.01);
  EXPECT_THAT(Content(Path("out/points.csv")), HasSubstr("100,100,"));
  for (const char* file : {"walls.geojson", "fit.png", "planning.pgm", "planning-mask.png"}) {
    EXPECT_FALSE(Content(Path("out") + "/" + file).empty()) << file;
  }
  // What was written can be read: the plan from each of its formats, and the map.
  for (const char* file : {"out/walls.svg", "out/walls.building.yaml"}) {
    ASSERT_OK(Run({"prior", "import", Path(file), "-o", Path("again.geojson")})) << file;
    EXPECT_GE(Printed()["walls"], 8) << file;
  }
  ASSERT_OK(Run({"prior", "fit", Path("plan/plan.svg"), Path("out/planning.yaml")}));
  EXPECT_EQ(Printed()["accepted"], true) << Printed()["reason"];
}

// Two corners of the plan, and where they are in the map of `robot`.
std::string PairsOf(const nlohmann::json& truth, const Pose2& start) {
  std::string pairs;
  const std::size_t last = truth["corners"].size() - 1;
  for (const std::size_t i : {std::size_t{0}, last}) {
    const nlohmann::json& corner = truth["corners"][i];
    const Eigen::Vector2d campus(corner["campus_m"][0], corner["campus_m"][1]);
    const Eigen::Vector2d map = Inverse(start) * campus;
    pairs += fmt::format("{},{},{},{}\n", corner["sheet_px"][0].get<double>(), corner["sheet_px"][1].get<double>(),
                         map.x(), map.y());
  }
  return pairs;
}

TEST_F(PriorCommandsTest, LocateFollowsADriveThroughThePlan) {
  Simulate();
  const nlohmann::json truth = nlohmann::json::parse(Content(Path("plan/plan-truth.json")));
  const std::string pairs = File("pairs.csv", PairsOf(truth, StartOf("robot")));
  const std::vector<std::string> command = {"prior",
                                            "locate",
                                            Path("plan/plan.geojson"),
                                            Path("campus/robot/log.jsonl"),
                                            "--pairs",
                                            pairs,
                                            "-o",
                                            Path("located.json"),
                                            "--plot",
                                            Path("located.png")};
  ASSERT_OK(Run(command));
  const nlohmann::json report = Printed();
  EXPECT_EQ(report["confident"], true);
  EXPECT_GT(report["travelled_m"], 20.0);
  ASSERT_FALSE(report["modes"].empty());
  const nlohmann::json& mode = report["modes"][0];
  EXPECT_GE(mode["mass"], 0.95);
  EXPECT_EQ(mode["covariance"].size(), 4U);
  EXPECT_EQ(mode["mirrored"], truth["mirrored"]);
  EXPECT_FALSE(report["submaps"].empty());
  EXPECT_FALSE(Content(Path("located.png")).empty());
  const nlohmann::json all = nlohmann::json::parse(Content(Path("located.json")));
  EXPECT_EQ(all["steps"].back()["modes"], report["modes"]);

  ASSERT_OK(Run(command));
  EXPECT_EQ(Printed()["modes"], report["modes"]);
}

TEST_F(PriorCommandsTest, LocateNamesWhatItCannotUse) {
  Simulate();
  const std::string log = Path("campus/robot/log.jsonl");
  EXPECT_STATUS(Run({"prior", "locate", Path("plan/plan.svg"), log, "--model", "best"}),
                absl::StatusCode::kInvalidArgument, HasSubstr("--model"));
  const std::string same = File("same.csv", "1,1,0,0\n1,1,9,9\n");
  EXPECT_STATUS(Run({"prior", "locate", Path("plan/plan.svg"), log, "--pairs", same}),
                absl::StatusCode::kInvalidArgument, HasSubstr("pairs 1 and 2 show the same point"));
  const std::string empty = File("empty.csv", "# nothing\n");
  EXPECT_STATUS(Run({"prior", "locate", Path("plan/plan.svg"), log, "--pairs", empty}),
                absl::StatusCode::kInvalidArgument, HasSubstr("empty.csv: no pairs"));
}

TEST_F(PriorCommandsTest, FitNamesAModeThatDoesNotExist) {
  EXPECT_STATUS(Run({"prior", "fit", "plan.png", "map.yaml", "--mode", "best"}), absl::StatusCode::kInvalidArgument,
                HasSubstr("--mode"));
}

TEST_F(PriorCommandsTest, FitNamesAnInputWithoutWallsByItsPath) {
  Simulate();
  const std::string empty = File("empty.pgm", "P5\n40 40\n255\n" + std::string(1600, '\xff'));
  EXPECT_STATUS(Run({"prior", "fit", Path("plan/plan.svg"), empty}), absl::StatusCode::kInvalidArgument,
                ::testing::StartsWith(empty + ": "));
  const std::string drive = Path("campus/robot/log.jsonl");
  EXPECT_STATUS(Run({"prior", "fit", Path("plan/plan.svg"), drive, empty}), absl::StatusCode::kInvalidArgument,
                ::testing::StartsWith(empty + ": "));
}

TEST_F(PriorCommandsTest, PlansNeedACampus) {
  EXPECT_STATUS(Run({"simulate", "-o", Path("drive.jsonl"), "--plan-out", Path("plan")}),
                absl::StatusCode::kInvalidArgument, HasSubstr("--plan-out"));
}

}  // namespace
}  // namespace enfilade::cli

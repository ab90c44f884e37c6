// SPDX-License-Identifier: Apache-2.0
// The graph of maps by the tool alone: two rooms imported, joined by a door, drawn, asked and changed.
#include <gmock/gmock.h>

#include <fstream>
#include <set>

#include "core/grid/files/png_codec.h"
#include "nlohmann/json.hpp"
#include "tests/e2e/whole_system.h"
#include "tests/support/command.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;

class GraphCommands : public ::testing::Test {
 protected:
  GraphCommands() : system_({}) {
    system_.CreateSite("s");
    for (const std::string name : {"Hall", "Lab"}) {
      WriteRoom(name);
      system_.Tool("s", {"map", "import", File(name + ".yaml"), "--map", name});
    }
  }

  std::string File(const std::string& name) const { return (system_.directory() / name).string(); }

  // 8 m x 6 m, with a wall around free ground.
  void WriteRoom(const std::string& name) const {
    constexpr int kWidth = 80;
    constexpr int kHeight = 60;
    std::string pixels;
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        const bool wall = row == 0 || row == kHeight - 1 || column == 0 || column == kWidth - 1;
        pixels += wall ? '\x00' : '\xfe';
      }
    }
    std::ofstream(File(name + ".pgm"), std::ios::binary) << "P5\n80 60\n255\n" << pixels;
    std::ofstream(File(name + ".yaml")) << "image: " << name
                                        << ".pgm\nresolution: 0.1\norigin: [0.0, -3.0, 0.0]\nnegate: 0\n"
                                           "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
  }

  json Run(const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {Program("enfilade"),        "--quiet", "--json", "--actor", "ann", "--server",
                                        system_.server().address(), "--site",  "s"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const CommandResult result = RunCommand(command);
    EXPECT_EQ(result.exit_code, 0) << arguments[0] << ' ' << arguments[1] << ": " << result.output;
    return json::parse(result.output, nullptr, false);
  }

  WholeSystem system_;
};

std::set<std::array<std::uint8_t, 3>> ColorsOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const auto image = grid::DecodePng(bytes);
  EXPECT_OK(image);
  std::set<std::array<std::uint8_t, 3>> colors;
  if (!image.ok()) return colors;
  for (std::size_t i = 0; i + 2 < image->samples.size(); i += 3) {
    colors.insert({image->samples[i], image->samples[i + 1], image->samples[i + 2]});
  }
  return colors;
}

TEST_F(GraphCommands, JoinDrawAskAndChange) {
  // The door is 8 m along the hall; the lab begins there and goes on.
  Run({"linkpoint", "candidate", "--id", "door", "--at", "Hall,8,0,0"});
  EXPECT_EQ(Run({"linkpoint", "list", "--candidates"}).size(), 1U);
  Run({"linkpoint", "set", "--id", "door", "--at", "Lab,0,0,0"});
  Run({"linkpoint", "candidate", "--id", "hatch", "--at", "Lab,4,2.5,1.57"});
  Run({"graph", "optimize"});

  const json shown = Run({"graph", "show"});
  EXPECT_EQ(shown["maps"].size(), 2U);
  EXPECT_EQ(shown["link_points"].size(), 2U);
  const json found = Run({"linkpoint", "near", "--at", "Hall,6,0,0", "--radius", "3"});
  ASSERT_EQ(found["found"].size(), 1U) << found;

  const json pose = Run({"pose", "global", "--at", "Lab,1,0,0"});
  EXPECT_NEAR(pose["pose_world_robot"]["x"], 9.0, 1e-6) << pose;
  const json routes = Run({"route", "Hall,1,0", "Lab,3,0"});
  ASSERT_EQ(routes["routes"].size(), 1U);
  EXPECT_NEAR(routes["routes"][0]["length_m"], 10.0, 1e-6);
  Run({"linkpoint", "state", "door", "blocked"});
  EXPECT_EQ(Run({"route", "Hall,1,0", "Lab,3,0"})["routes"].size(), 0U);

  const json plotted = Run({"graph", "plot", "-o", File("graph.png"), "--near", "Hall,2,0,0"});
  EXPECT_EQ(plotted["maps"], 2);
  EXPECT_EQ(plotted["grids"], 2);
  EXPECT_EQ(plotted["link_points"], 2);
  const auto colors = ColorsOf(File("graph.png"));
  const std::array<std::uint8_t, 3> red{214, 39, 40};         // the search radius
  const std::array<std::uint8_t, 3> orange{230, 120, 0};      // the candidate
  const std::array<std::uint8_t, 3> first_walls{16, 60, 90};  // each map's walls in its colour
  const std::array<std::uint8_t, 3> second_walls{107, 20, 20};
  for (const auto& color : {red, orange, first_walls, second_walls}) EXPECT_THAT(colors, Contains(color));
  Run({"graph", "plot", "-o", File("graph.svg")});
  std::ifstream svg(File("graph.svg"));
  const std::string text((std::istreambuf_iterator<char>(svg)), {});
  EXPECT_THAT(text, HasSubstr(">hatch<"));
  EXPECT_THAT(text, HasSubstr(">Lab<"));

  const json audit = Run({"site", "audit", "linkPoints/door"});
  ASSERT_FALSE(audit.empty());
  EXPECT_EQ(audit[0]["action"], "updated");
  EXPECT_EQ(audit[0]["actor"], "ann");
  Run({"linkpoint", "delete", "hatch"});
  EXPECT_EQ(Run({"graph", "show"})["link_points"].size(), 1U);
  EXPECT_FALSE(Run({"graph", "versions"}).empty());
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
// Maps edited by the tool alone, against a real server: drawn, checked, published, merged, contested and exported.
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>

#include "nlohmann/json.hpp"
#include "tests/e2e/whole_system.h"
#include "tests/support/command.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class EditCommands : public ::testing::Test {
 protected:
  EditCommands() : system_({}) { system_.CreateSite("s"); }

  std::string File(const std::string& name, const std::string& content = "") const {
    const std::string path = (system_.directory() / name).string();
    if (!content.empty()) std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  static std::string Content(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  // 8 m x 6 m of free ground, with (0, -3) at its lower left.
  void ImportHall() {
    File("hall.pgm", "P5\n80 60\n255\n" + std::string(4800, '\xfe'));
    File("hall.yaml",
         "image: hall.pgm\nresolution: 0.1\norigin: [0.0, -3.0, 0.0]\nnegate: 0\n"
         "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
    Run({"map", "import", File("hall.yaml"), "--map", "Hall"});
  }
  // How many pixels of the exported image differ from those imported; it has `grey` in all of them.
  int ChangedPixels(char grey) {
    Run({"map", "export", "Hall", "-o", File("exported")});
    const std::string before = Content(File("hall.pgm"));
    const std::string after = Content(File("exported/Hall.pgm"));
    EXPECT_EQ(before.size(), after.size());
    int changed = 0;
    for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
      if (before[i] == after[i]) continue;
      ++changed;
      EXPECT_EQ(after[i], grey) << i;
    }
    return changed;
  }

  CommandResult Try(const std::vector<std::string>& arguments, const std::string& actor = "ann") {
    std::vector<std::string> command = {Program("enfilade"),        "--quiet", "--json", "--actor", actor, "--server",
                                        system_.server().address(), "--site",  "s"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return RunCommand(command);
  }
  json Run(const std::vector<std::string>& arguments, const std::string& actor = "ann") {
    const CommandResult result = Try(arguments, actor);
    EXPECT_EQ(result.exit_code, 0) << arguments[0] << ' ' << arguments[1] << ": " << result.output;
    return json::parse(result.output, nullptr, false);
  }
  void Drive(const std::string& session) {
    const Replay replay{.site = "s", .session = session};
    EXPECT_EQ(system_.StartReplay(replay, system_.server())->Wait(std::chrono::minutes(5)), 0)
        << TailOf(system_.ReplayLog(replay));
  }

  WholeSystem system_;
};

TEST_F(EditCommands, AFileIsDrawnCheckedAndPublished) {
  ImportHall();
  const std::string file =
      File("walls.yaml",
           "author: Ann\n"
           "edits:\n"
           "- {rectangle: [[1, -1], [2, 0]], value: occupied}\n"                           // 100 cells
           "- {rectangle: [[1.5, -1], [2, 0]], value: clear}\n"                            // 50 of them
           "- {line: [[5.05, 0.05], [6.05, 0.05]], value: occupied, invisible: true}\n");  // 11 cells
  const json drawn = Run({"map", "edit", "Hall", file, "--draft", "walls"});
  EXPECT_EQ(drawn["added"], 3);
  const json again = Run({"map", "edit", "Hall", file, "--draft", "walls"});
  EXPECT_EQ(again["added"], 0);
  EXPECT_EQ(again["already_there"], 3);

  const json shown = Run({"map", "draft", "show", "Hall", "walls"});
  ASSERT_EQ(shown["edits"].size(), 3U) << shown;
  EXPECT_EQ(shown["edits"][0]["author"], "Ann");
  EXPECT_EQ(shown["edits"][2]["invisible"], true);
  EXPECT_EQ(shown["state"], "open");
  const std::string line = shown["edits"][2]["editId"];
  EXPECT_THAT(Try({"map", "draft", "undo", "Hall", "walls", line}).output, HasSubstr("Ann"));  // it is not ann's
  Run({"map", "draft", "undo", "Hall", "walls", line, "--others"});
  EXPECT_EQ(Run({"map", "publish", "Hall", "walls", "--dry-run"})["changes"]["to_occupied"], 50);
  Run({"map", "draft", "redo", "Hall", "walls", line, "--others"});

  const json checked = Run({"map", "publish", "Hall", "walls", "--dry-run"});
  EXPECT_EQ(checked["changes"]["to_occupied"], 61) << checked;
  EXPECT_EQ(checked["can_publish"], true);
  EXPECT_EQ(ChangedPixels('\0'), 0);
  EXPECT_THAT(Try({"map", "publish", "Hall", "walls"}).output, HasSubstr("--message"));
  const json published = Run({"map", "publish", "Hall", "walls", "--message", "Walls of glass"});
  EXPECT_EQ(published["edit_version"], 1) << published;
  EXPECT_EQ(ChangedPixels('\0'), 61);

  EXPECT_EQ(Run({"map", "draft", "list", "Hall"}).size(), 0U);
  const json all = Run({"map", "draft", "list", "Hall", "--published"});
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0]["message"], "Walls of glass");
  EXPECT_THAT(Try({"map", "draft", "delete", "Hall", "walls"}).output, HasSubstr("published"));

  File("clear.yaml",
       "unit: cells\nedits:\n- {fill: [12, 22], value: clear}\n- {brush: [[55, 30]], radius: 9, value: clear}\n");
  Run({"map", "edit", "Hall", File("clear.yaml"), "--draft", "clear"});
  Run({"map", "publish", "Hall", "clear", "--message", "As it was"});
  EXPECT_EQ(ChangedPixels('\0'), 0);
  EXPECT_EQ(Content(File("exported/Hall.pgm")), Content(File("hall.pgm")));
}

TEST_F(EditCommands, FilesThatAreWrongDrawNothing) {
  ImportHall();
  const auto refused = [&](const std::string& yaml) {
    const CommandResult result = Try({"map", "edit", "Hall", File("wrong.yaml", yaml)});
    EXPECT_EQ(result.exit_code, 2) << result.output;
    return result.output;
  };
  EXPECT_THAT(refused("edits:\n- {brush: [[1, 1]], radius: 0.2}\n"), HasSubstr("line 2: edits[0].value is missing"));
  EXPECT_THAT(refused("edits:\n- {line: [[1, 1], [2, 2]], value: red}\n"), HasSubstr("\"red\""));
  EXPECT_THAT(refused("edits:\n- {line: [[500, 1]], value: free}\n"), HasSubstr("outside of the map"));
  EXPECT_EQ(Run({"map", "draft", "list", "Hall"}).size(), 0U);
}

TEST_F(EditCommands, ConflictsAreSettledByRebase) {
  ImportHall();
  File("bob.yaml", "edits:\n- {rectangle: [[1, -1], [2, 0]], value: occupied}\n");
  File("ann.yaml", "edits:\n- {rectangle: [[1.5, -1], [3, 0]], value: unknown}\n");
  Run({"map", "edit", "Hall", File("ann.yaml"), "--draft", "a"});
  Run({"map", "edit", "Hall", File("ann.yaml"), "--draft", "b"});
  Run({"map", "edit", "Hall", File("bob.yaml"), "--draft", "c"}, "bob");
  Run({"map", "publish", "Hall", "c", "-m", "Bob's wall"}, "bob");

  const CommandResult checked = Try({"map", "publish", "Hall", "a", "--dry-run"});
  EXPECT_EQ(checked.exit_code, 1);
  EXPECT_THAT(checked.output, HasSubstr("rebase"));
  EXPECT_THAT(checked.output, HasSubstr("15,20"));
  EXPECT_NE(Try({"map", "publish", "Hall", "a", "-m", "Mine"}).exit_code, 0);
  EXPECT_EQ(Try({"map", "rebase", "Hall", "a", "--mine", "3,3"}).exit_code, 3);
  EXPECT_NE(Try({"map", "rebase", "Hall", "a"}).exit_code, 0);
  EXPECT_EQ(ChangedPixels('\0'), 100);

  Run({"map", "rebase", "Hall", "a", "--theirs", "15,20"});
  EXPECT_EQ(Run({"map", "publish", "Hall", "a", "-m", "Theirs"})["changes"]["to_unknown"], 100);
  EXPECT_EQ(Try({"map", "rebase", "Hall", "b", "--mine", "all", "--theirs", "all"}).exit_code, 2);
  Run({"map", "rebase", "Hall", "b", "--mine", "all"});
  EXPECT_EQ(Run({"map", "publish", "Hall", "b", "-m", "Mine"})["changes"]["to_unknown"], 50);
}

TEST_F(EditCommands, WhatRobotsSeeAgainIsContestedAndSettled) {
  system_.RecordDrive(1);
  Drive("first");
  File("erase.yaml", "edits:\n- {rectangle: [[-45, -45], [45, 45]], value: free, only_where: [occupied]}\n");
  Run({"map", "edit", "Rooms", File("erase.yaml"), "--draft", "erase"});
  Run({"map", "publish", "Rooms", "erase", "-m", "No walls", "--confirm"});
  EXPECT_EQ(Run({"map", "contested", "Rooms"}).size(), 0U);
  Drive("second");
  const json contested = Run({"map", "contested", "Rooms"});
  ASSERT_GT(contested.size(), 1U);
  EXPECT_EQ(contested[0]["edited"], "free");
  EXPECT_EQ(contested[0]["seen"], "occupied");
  EXPECT_EQ(contested[0]["message"], "No walls");
  EXPECT_THAT(contested[0]["place"].get<std::string>(), HasSubstr("second@"));
  EXPECT_EQ(Try({"map", "contested", "Rooms", "--keep", "second@77777,0"}).exit_code, 3);
  Run({"map", "contested", "Rooms", "--keep", contested[0]["place"], "--drop", contested[1]["place"]});
  EXPECT_EQ(Run({"map", "contested", "Rooms"}).size(), contested.size() - 2);
  Run({"map", "contested", "Rooms", "--drop", "all"});
  EXPECT_EQ(Run({"map", "contested", "Rooms"}).size(), 0U);
}

}  // namespace
}  // namespace enfilade::testing

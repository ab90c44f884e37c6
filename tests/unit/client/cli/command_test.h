// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/cli/command.h"
#include "tests/support/test_data.h"

namespace enfilade::cli {

// Runs commands of the tool in this process, with a folder of its own.
class CommandTest : public ::testing::Test {
 protected:
  std::string File(const std::string& name, const std::string& content) const {
    const std::string path = directory_.path() / name;
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  static std::string Content(const std::filesystem::path& path) {
    std::stringstream content;
    content << std::ifstream(path, std::ios::binary).rdbuf();
    return content.str();
  }

  // `add`: AddSlam and its like. What the command prints goes to `printed_`. A wrong use is INVALID_ARGUMENT.
  template <typename Add>
  absl::Status RunCommandLine(const Add& add, std::vector<std::string> arguments, bool json) {
    Globals globals = globals_;
    globals.json = json;
    globals.quiet = json;
    CLI::App app("enfilade");
    add(app, globals);
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
    std::stringstream printed;
    std::streambuf* const terminal = std::cout.rdbuf(printed.rdbuf());
    absl::Status status;
    try {
      app.parse(arguments);
    } catch (const CommandFailed& failed) {
      status = failed.status;
    } catch (const CLI::ParseError& error) {
      status = absl::InvalidArgumentError(error.what());
    }
    std::cout.rdbuf(terminal);
    printed_ = printed.str();
    return status;
  }

  enfilade::testing::TemporaryDirectory directory_;
  Globals globals_;  // of every run, apart from --json and --quiet
  std::string printed_;
};

}  // namespace enfilade::cli

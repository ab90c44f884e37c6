// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace enfilade::testing {

// A recording by others, in $ENFILADE_DATA or else in ../shared/data beside the project; nullopt if it is not there.
std::optional<std::filesystem::path> FindRecording(const std::string& relative);

// A small file of the project's own, in tests/data.
std::filesystem::path ProjectData(const std::string& relative);

// A program of the project, built into the same folder as the running test.
std::filesystem::path Program(const std::string& name);

// A new empty directory; the destructor removes it with its content.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace enfilade::testing

// Skips the test, with a message, if the recording is not on this machine.
#define ENFILADE_RECORDING_OR_SKIP(variable, relative)                                                    \
  const auto variable##_found = enfilade::testing::FindRecording(relative);                               \
  if (!variable##_found) GTEST_SKIP() << "recording " << (relative) << " is not here: set ENFILADE_DATA"; \
  const std::filesystem::path variable = *variable##_found

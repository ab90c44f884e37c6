// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace enfilade::testing {

// Recordings by others: $ENFILADE_DATA, or else ../shared/data beside the project. Empty where absent.
std::optional<std::filesystem::path> FindRecording(const std::string& relative);

// Small files made by the project: tests/data.
std::filesystem::path ProjectData(const std::string& relative);

// A program of ours, built into the same folder as the running test.
std::filesystem::path Program(const std::string& name);

// A new empty directory that is removed with its content when the guard goes.
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

// Ends the test as skipped, with a message, where a recording is not on this machine.
#define ENFILADE_RECORDING_OR_SKIP(variable, relative)                                                    \
  const auto variable##_found = enfilade::testing::FindRecording(relative);                               \
  if (!variable##_found) GTEST_SKIP() << "recording " << (relative) << " is not here: set ENFILADE_DATA"; \
  const std::filesystem::path variable = *variable##_found

// SPDX-License-Identifier: Apache-2.0
#include "io/program.h"

#include <gtest/gtest.h>

#include <string>

namespace enfilade::io {
namespace {

TEST(RunProgram, GivesTheProgramItsInputAndReturnsWhatItWrote) {
  const std::string input(3'000'000, 'x');  // more than any buffer holds
  const auto result = RunProgram({"cat"}, input);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->exit_code, 0);
  EXPECT_EQ(result->output, input);
}

TEST(RunProgram, SeparatesErrorsAndReturnsTheExitCode) {
  const auto result = RunProgram({"sh", "-c", "echo out; echo err >&2; exit 3"}, "not read");
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->exit_code, 3);
  EXPECT_EQ(result->output, "out\n");
  EXPECT_EQ(result->errors, "err\n");
}

TEST(RunProgram, KeepsToItsLimits) {
  EXPECT_EQ(RunProgram({"no-such-program-here"}, "").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(RunProgram({"sleep", "60"}, "", {.time = std::chrono::seconds(1)}).status().code(),
            absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(RunProgram({"yes"}, "", {.output_bytes = 100'000}).status().code(), absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace enfilade::io

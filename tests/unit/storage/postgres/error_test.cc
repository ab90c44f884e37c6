// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/error.h"

#include <utility>

#include "gtest/gtest.h"

namespace enfilade::storage::postgres {
namespace {

using absl::StatusCode;

class SqlStateTest : public ::testing::TestWithParam<std::pair<const char*, StatusCode>> {};

TEST_P(SqlStateTest, MeansToTheCaller) {
  const auto& [sqlstate, code] = GetParam();
  EXPECT_EQ(CodeOfSqlState(sqlstate), code) << sqlstate;
}

INSTANTIATE_TEST_SUITE_P(
    All, SqlStateTest,
    ::testing::Values(
        std::pair("40001", StatusCode::kAborted), std::pair("40P01", StatusCode::kAborted),
        std::pair("23505", StatusCode::kAlreadyExists), std::pair("23503", StatusCode::kFailedPrecondition),
        std::pair("23514", StatusCode::kInvalidArgument), std::pair("23502", StatusCode::kInvalidArgument),
        std::pair("22021", StatusCode::kInvalidArgument), std::pair("57014", StatusCode::kDeadlineExceeded),
        std::pair("57P01", StatusCode::kUnavailable), std::pair("57P02", StatusCode::kUnavailable),
        std::pair("57P03", StatusCode::kUnavailable), std::pair("08006", StatusCode::kUnavailable),
        std::pair("53300", StatusCode::kUnavailable), std::pair("25006", StatusCode::kUnavailable),
        std::pair("53100", StatusCode::kResourceExhausted), std::pair("53200", StatusCode::kResourceExhausted),
        std::pair("42501", StatusCode::kUnavailable), std::pair("42P01", StatusCode::kUnavailable),
        std::pair("42703", StatusCode::kUnavailable), std::pair("42883", StatusCode::kUnavailable),
        std::pair("28P01", StatusCode::kUnavailable), std::pair("28000", StatusCode::kUnavailable),
        std::pair("3F000", StatusCode::kUnavailable), std::pair("3D000", StatusCode::kUnavailable),
        std::pair("42601", StatusCode::kInternal), std::pair("XX000", StatusCode::kInternal)));

TEST(SqlStateTest, AStatusOfOursNamesNone) {
  EXPECT_EQ(SqlStateOf(absl::InternalError("x")), "");
  EXPECT_EQ(ConstraintOf(absl::OkStatus()), "");
}

}  // namespace
}  // namespace enfilade::storage::postgres

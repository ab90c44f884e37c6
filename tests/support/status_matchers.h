#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace enfilade::testing {

inline const absl::Status& StatusOf(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusOf(const absl::StatusOr<T>& status_or) {
  return status_or.status();
}
inline std::string MessageOf(const absl::Status& status) { return {status.message().data(), status.message().size()}; }

MATCHER(IsOk, "is OK") {
  *result_listener << StatusOf(arg).ToString();
  return StatusOf(arg).ok();
}

// EXPECT_THAT(Load(path), HasStatus(absl::StatusCode::kNotFound, HasSubstr("no such file")));
MATCHER_P2(HasStatus, code, message, "has the code and a fitting message") {
  const absl::Status& status = StatusOf(arg);
  *result_listener << status.ToString();
  return status.code() == code && ::testing::ExplainMatchResult(message, MessageOf(status), result_listener);
}
MATCHER_P(HasCode, code, "has the code") {
  *result_listener << StatusOf(arg).ToString();
  return StatusOf(arg).code() == code;
}

}  // namespace enfilade::testing

#define ENFILADE_TEST_CONCAT_INNER(a, b) a##b
#define ENFILADE_TEST_CONCAT(a, b) ENFILADE_TEST_CONCAT_INNER(a, b)
#define ASSERT_OK(expression) ASSERT_THAT((expression), ::enfilade::testing::IsOk())
#define EXPECT_OK(expression) EXPECT_THAT((expression), ::enfilade::testing::IsOk())
#define ASSERT_OK_AND_ASSIGN(declaration, expression) \
  ASSERT_OK_AND_ASSIGN_INNER(ENFILADE_TEST_CONCAT(enfilade_test_status_or_, __LINE__), declaration, expression)
#define ASSERT_OK_AND_ASSIGN_INNER(temporary, declaration, expression) \
  auto temporary = (expression);                                       \
  ASSERT_THAT(temporary, ::enfilade::testing::IsOk());                 \
  declaration = *std::move(temporary)

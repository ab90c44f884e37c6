// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

// EXPECT_OK(store.Put(item));
// ASSERT_OK_AND_ASSIGN(const Item item, store.Get(id));
// EXPECT_CODE(store.Get(id), absl::StatusCode::kNotFound);
// EXPECT_STATUS(Load(path), absl::StatusCode::kNotFound, HasSubstr("no such file"));
//
// Each takes an absl::Status or an absl::StatusOr. They are functions and not matchers of GoogleMock, because the
// compiler would instantiate a matcher for each type of value, which takes long for what is asserted so often.

namespace enfilade::testing {

inline const absl::Status& StatusOf(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusOf(const absl::StatusOr<T>& status_or) {
  return status_or.status();
}
inline std::string MessageOf(const absl::Status& status) { return {status.message().data(), status.message().size()}; }

inline ::testing::AssertionResult IsOk(const char* expression, const absl::Status& status) {
  if (status.ok()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << expression << " is " << status.ToString() << ", expected OK";
}

inline ::testing::AssertionResult HasCode(const char* expression, const char*, const absl::Status& status,
                                          absl::StatusCode code) {
  if (status.code() == code) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << expression << " is " << status.ToString() << ", expected "
                                       << absl::StatusCodeToString(code);
}

inline ::testing::AssertionResult HasStatus(const char* expression, const char*, const char*,
                                            const absl::Status& status, absl::StatusCode code,
                                            const ::testing::Matcher<std::string>& message) {
  if (status.code() == code && message.Matches(MessageOf(status))) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << expression << " is " << status.ToString() << ", expected "
                                       << absl::StatusCodeToString(code) << " and a message that "
                                       << ::testing::DescribeMatcher<std::string>(message);
}

}  // namespace enfilade::testing

#define ENFILADE_TEST_CONCAT_INNER(a, b) a##b
#define ENFILADE_TEST_CONCAT(a, b) ENFILADE_TEST_CONCAT_INNER(a, b)
#define ENFILADE_TEST_STATUS(expression) ::enfilade::testing::StatusOf(expression)
#define ASSERT_OK(expression) ASSERT_PRED_FORMAT1(::enfilade::testing::IsOk, ENFILADE_TEST_STATUS(expression))
#define EXPECT_OK(expression) EXPECT_PRED_FORMAT1(::enfilade::testing::IsOk, ENFILADE_TEST_STATUS(expression))
#define EXPECT_CODE(expression, code) \
  EXPECT_PRED_FORMAT2(::enfilade::testing::HasCode, ENFILADE_TEST_STATUS(expression), code)
#define EXPECT_STATUS(expression, code, message) \
  EXPECT_PRED_FORMAT3(::enfilade::testing::HasStatus, ENFILADE_TEST_STATUS(expression), code, message)
#define ASSERT_OK_AND_ASSIGN(declaration, expression) \
  ASSERT_OK_AND_ASSIGN_INNER(ENFILADE_TEST_CONCAT(enfilade_test_status_or_, __LINE__), declaration, expression)
#define ASSERT_OK_AND_ASSIGN_INNER(temporary, declaration, expression) \
  auto temporary = (expression);                                       \
  ASSERT_OK(temporary);                                                \
  declaration = *std::move(temporary)

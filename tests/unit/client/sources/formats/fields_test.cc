// SPDX-License-Identifier: Apache-2.0
#include "client/sources/formats/fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::sources {
namespace {

TEST(Fields, ReadsFieldsBetweenAnyBlanks) {
  Fields fields("  TAG\t-7  +1.5e2\f 2.25   1 2 3 0.5 ");
  EXPECT_EQ(fields.Word("tag"), "TAG");
  EXPECT_EQ(fields.Integer("count"), -7);
  EXPECT_EQ(fields.Number("number"), 150.0);
  EXPECT_EQ(fields.Seconds("time"), 2'250'000'000);
  EXPECT_THAT(fields.Pose("pose", 0.01), testing::PoseNear(Pose2{0.01, 0.02, 3.0}, 1e-12, 1e-12));
  fields.Skip("rest", 1);
  fields.ExpectEnd();
  EXPECT_OK(fields.status());
}

TEST(Fields, ReadsRangesWithTheirScale) {
  Fields fields("1 nan -1 inf 2.5e-400");
  const std::vector<float> ranges = fields.Ranges("range", 5, 0.5);
  ASSERT_OK(fields.status());
  EXPECT_EQ(ranges[0], 0.5F);
  EXPECT_TRUE(std::isnan(ranges[1]));
  EXPECT_EQ(ranges[2], -0.5F);
  EXPECT_TRUE(std::isinf(ranges[3]));
  EXPECT_EQ(ranges[4], 0.0F) << "numbers below the smallest double are zero";
}

struct FieldError {
  const char* name;
  const char* line;
  std::function<void(Fields&)> read;
  const char* message;
};

class FieldErrors : public ::testing::TestWithParam<FieldError> {};

TEST_P(FieldErrors, NameTheFieldAndStay) {
  Fields fields(GetParam().line);
  GetParam().read(fields);
  EXPECT_STATUS(fields.status(), absl::StatusCode::kInvalidArgument, ::testing::HasSubstr(GetParam().message));
  const absl::Status first = fields.status();
  EXPECT_EQ(fields.Number("later"), 0.0);
  EXPECT_EQ(fields.Word("later"), "");
  EXPECT_EQ(fields.Integer("later"), 0);
  EXPECT_EQ(fields.Seconds("later"), 0);
  EXPECT_TRUE(fields.Ranges("later", 2).empty());
  fields.ExpectEnd();
  fields.ExpectRemaining(9, "later");
  EXPECT_EQ(fields.status(), first) << "the first error is kept";
}

INSTANTIATE_TEST_SUITE_P(
    All, FieldErrors,
    ::testing::Values(
        FieldError{"EmptyLine", "", [](Fields& f) { f.Word("tag"); }, "the line ends before field 1 (tag)"},
        FieldError{"OnlyBlanks", "  \t", [](Fields& f) { f.Number("x"); }, "the line ends before field 1 (x)"},
        FieldError{"SecondMissing", "1",
                   [](Fields& f) {
                     f.Number("x");
                     f.Number("y");
                   },
                   "the line ends before field 2 (y)"},
        FieldError{"Word", "x", [](Fields& f) { f.Number("x"); }, "field 1 (x) is \"x\": expected a number"},
        FieldError{"HalfANumber", "1.5m", [](Fields& f) { f.Number("x"); }, "expected a number"},
        FieldError{"TwoSigns", "--1", [](Fields& f) { f.Integer("n"); }, "field 1 (n) is \"--1\""},
        FieldError{"PlusAlone", "+", [](Fields& f) { f.Number("x"); }, "is \"+\""},
        FieldError{"Hexadecimal", "0x10", [](Fields& f) { f.Integer("n"); }, "expected an integer"},
        FieldError{"Nan", "nan", [](Fields& f) { f.Number("x"); }, "is nan: expected a finite number"},
        FieldError{"Infinity", "inf", [](Fields& f) { f.Number("x"); }, "expected a finite number"},
        FieldError{"HugeNumber", "1e999", [](Fields& f) { f.Number("x"); }, "field 1 (x) is \"1e999\""},
        FieldError{"HugeInteger", "9223372036854775808", [](Fields& f) { f.Integer("n"); }, "expected an integer"},
        FieldError{"Fraction", "2.0", [](Fields& f) { f.Integer("n"); }, "expected an integer"},
        FieldError{"Time", "12:30", [](Fields& f) { f.Seconds("time"); }, "expected seconds"},
        FieldError{"Pose", "1 2 x", [](Fields& f) { f.Pose("odometry"); }, "field 3 (odometry.theta) is \"x\""},
        FieldError{"LongWord", "0123456789012345678901234567890123456789012345", [](Fields& f) { f.Integer("n"); },
                   "\"0123456789012345678901234567890123456789...\""},
        FieldError{"Range", "1 2 far", [](Fields& f) { f.Ranges("range", 3); },
                   "field 3 (range 3 of 3) is \"far\": expected a number"},
        FieldError{"NoRanges", "1", [](Fields& f) { f.Ranges("range", 0); }, "is 0: expected 1 to 100000"},
        FieldError{"TooManyRanges", "1", [](Fields& f) { f.Ranges("range", 100'001); }, "is 100001"},
        FieldError{"Leftover", "1 2",
                   [](Fields& f) {
                     f.Number("x");
                     f.ExpectEnd();
                   },
                   "fields follow after the last one expected (1)"},
        FieldError{"TooFewLeft", "1 2",
                   [](Fields& f) {
                     f.Number("x");
                     f.ExpectRemaining(3, "3 are announced");
                   },
                   "3 are announced: the line needs 4 fields and has 2"},
        FieldError{"SkipTooFar", "1 2", [](Fields& f) { f.Skip("unused", 3); }, "before field 3 (unused)"},
        FieldError{"OwnError", "1", [](Fields& f) { f.Fail("of the format"); }, "of the format"}),
    [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace enfilade::sources

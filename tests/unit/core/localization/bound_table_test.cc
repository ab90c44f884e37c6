// SPDX-License-Identifier: Apache-2.0
#include "core/localization/bound_table.h"

#include <algorithm>

#include "gtest/gtest.h"

namespace enfilade::localization {
namespace {

TEST(BoundTableTest, EachEntryIsTheLargestOfItsBlock) {
  slam::LikelihoodField field(0.1, 0.6);
  field.Add({{0.33, 0.21}, {1.5, -0.4}, {-0.8, 0.9}});
  const BoundTable table(field, 0.15, 5);
  const BoundTable::View lowest = table.ViewOf(0);
  EXPECT_EQ(lowest.At(3, 2), 244) << "the cell's centre is 0.045 m away from the point";
  const slam::CellWindow& window = field.window();
  for (int level = 1; level < table.levels(); ++level) {
    const int size = 1 << level;
    const BoundTable::View view = table.ViewOf(level);
    for (int row = window.min.row - size - 2; row < window.top() + 2; row += 3) {
      for (int column = window.min.column - size - 2; column < window.right() + 2; column += 3) {
        int largest = 0;
        for (int r = row; r < row + size; ++r) {
          for (int c = column; c < column + size; ++c) largest = std::max(largest, lowest.At(c, r));
        }
        ASSERT_EQ(view.At(column, row), largest) << level << " " << column << " " << row;
      }
    }
  }
}

}  // namespace
}  // namespace enfilade::localization

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "core/edit/map_edit.h"

namespace enfilade::edit {

// Cells of one row, from `begin` to before `end`.
struct Span {
  int row = 0;
  int begin = 0;
  int end = 0;
};
using VisitSpan = std::function<void(const Span& span)>;

// The cells of a valid shape. May visit a cell more than once.
void VisitSpans(const Shape& shape, const VisitSpan& visit);

// Around its cells; may be larger by a cell or two.
CellBox BoxOf(const Shape& shape);

}  // namespace enfilade::edit

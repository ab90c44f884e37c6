// SPDX-License-Identifier: Apache-2.0
// Shapes of edits as they are stored.
#include "core/edit/map_edit.h"
#include "core/edit/spans.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  return {edit::Encode(edit::Brush{{{128, 128}, {-9000, 300}, {-8000, 301}}, 600}),
          edit::Encode(edit::Line{{{0, 0}, {5000, -2500}}}),
          edit::Encode(
              edit::Polygon{{{{0, 0}, {9000, 0}, {9000, 9000}, {0, 9000}}, {{600, 600}, {600, 2000}, {2000, 600}}}}),
          edit::Encode(edit::Patch{{-3, 250, 20, 30}, {5, 7, 100, 40, 3, 200}})};
}

bool Decode(std::string_view bytes) {
  const auto shape = edit::DecodeShape(bytes);
  if (!shape.ok()) return false;
  Expect(edit::Encode(*shape) == bytes, "a shape is written as it was read");
  Expect(edit::ValidateForm(*shape).ok(), "a shape is valid");
  if (!edit::Validate(*shape).ok()) return true;
  const edit::CellBox box = edit::BoxOf(*shape);
  edit::VisitSpans(*shape, [&](const edit::Span& span) {
    Expect(span.begin < span.end && box.contains(span.begin, span.row) && box.contains(span.end - 1, span.row),
           "cells are inside the box");
  });
  return true;
}

}  // namespace enfilade::fuzz

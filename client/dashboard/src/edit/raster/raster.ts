// SPDX-License-Identifier: Apache-2.0
// Which cells an edit has: the same ones as on the server (core/edit/spans.cc), all in integers. The tests of both read the
// same examples (tests/data/edits).
import type { MapEdit } from '../../gen/enfilade/v1/map_edit_pb';
import { addBrush } from './brush';
import { addLine } from './line';
import { addPatch } from './patch';
import { addPolygon } from './polygon';
import { NONE, SpanList, type Spans } from './spans';

export type Shape = MapEdit['shape'];

// None of a fill: the server finds its cells.
export function rasterised(shape: Shape): Spans {
  const list = new SpanList();
  switch (shape.case) {
    case 'brush':
      addBrush(list, shape.value.points, shape.value.radius);
      break;
    case 'line':
      addLine(list, shape.value.points);
      break;
    case 'polygon':
      addPolygon(list, shape.value.rings.map(({ points }) => points));
      break;
    case 'patch':
      if (shape.value.box) addPatch(list, shape.value.box, shape.value.runs);
      break;
    default:
      return NONE;
  }
  return list.take();
}

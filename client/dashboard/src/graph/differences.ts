// SPDX-License-Identifier: Apache-2.0
// What somebody else has made of a link point, in words.
import { LinkPoint_Kind as Kind, LinkPoint_State as State, LinkPoint_Use as Use, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import { turned } from '../ui/format';
import { wrapped } from '../scene/se2';
import { placeOf } from './draft';
import { lengthText } from './preview';
import { spreadOf, spreadText } from './spread';

export const kindNames: Record<Kind, string> = {
  [Kind.UNSPECIFIED]: 'Door', [Kind.DOOR]: 'Door', [Kind.LIFT]: 'Lift', [Kind.STAIRS]: 'Stairs', [Kind.RAMP]: 'Ramp', [Kind.OPENING]: 'Opening',
};

export const stateNames: Record<State, string> = {
  [State.UNSPECIFIED]: 'Open', [State.OPEN]: 'Open', [State.CLOSED]: 'Closed', [State.BLOCKED]: 'Blocked',
};

function anchorDifferences(base: LinkPoint, theirs: LinkPoint, titleOf: (name: string) => string): string[] {
  const said: string[] = [];
  for (const anchor of theirs.anchors) {
    const before = base.anchors.find(({ map }) => map === anchor.map);
    const in_ = `Anchor in ${titleOf(anchor.map)}`;
    if (!before) {
      said.push(`${in_}: added`);
      continue;
    }
    const [was, is] = [placeOf(before), placeOf(anchor)];
    const [way, turn] = [Math.hypot(is.pose.x - was.pose.x, is.pose.y - was.pose.y), wrapped(is.pose.yaw - was.pose.yaw)];
    if (way > 0 || turn !== 0) said.push(`${in_}: moved by ${lengthText(way)}, ${turned(turn)}`);
    if (is.covariance.some((value, i) => value !== was.covariance[i])) said.push(`${in_}: σ ${spreadText(spreadOf(was.covariance))} → ${spreadText(spreadOf(is.covariance))}`);
  }
  for (const { map } of base.anchors) if (!theirs.anchors.some((anchor) => anchor.map === map)) said.push(`Anchor in ${titleOf(map)}: taken away`);
  return said;
}

// Undefined: it is no longer there.
export function differencesOf(base: LinkPoint, theirs: LinkPoint | undefined, titleOf: (name: string) => string): string[] {
  if (!theirs) return ['Deleted'];
  const said = anchorDifferences(base, theirs, titleOf);
  if (kindNames[base.kind] !== kindNames[theirs.kind]) said.push(`Kind: ${kindNames[base.kind]} → ${kindNames[theirs.kind]}`);
  if (stateNames[base.state] !== stateNames[theirs.state]) said.push(`State: ${stateNames[base.state]} → ${stateNames[theirs.state]}`);
  if (base.tag !== theirs.tag) said.push(`Tag: “${base.tag}” → “${theirs.tag}”`);
  if (base.difficulty !== theirs.difficulty) said.push(`Difficulty: ${base.difficulty} → ${theirs.difficulty}`);
  const suspended = [base, theirs].map(({ use }) => use === Use.SUSPENDED);
  if (suspended[0] !== suspended[1]) said.push(suspended[1] ? 'Suspended' : 'Resumed');
  return said.length > 0 ? said : ['Something that this page does not show'];
}

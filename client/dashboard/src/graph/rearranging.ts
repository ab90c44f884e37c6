// SPDX-License-Identifier: Apache-2.0
// What a merge or a split would do, in words, before it is done (docs/rearrange.md).
import type { GraphLinkPoint } from '../gen/enfilade/v1/graph_pb';
import { Session_State, type Session } from '../gen/enfilade/v1/session_pb';
import { count } from '../ui/format';

export interface MergePlan {
  // The map that stays, and the one that becomes a part of it.
  stays: string;
  goes: string;
  lines: string[];
  // Why it cannot be made.
  refusal: string | undefined;
}

const isOpen = ({ state }: Pick<Session, 'state'>) => state === Session_State.RECORDING || state === Session_State.FINISHED;

// The map that carries the world frame always stays.
export function planMerge(into: string, merged: string, root: string, points: readonly GraphLinkPoint[], sessions: readonly Session[], titleOf: (name: string) => string): MergePlan {
  const [stays, goes] = merged === root ? [merged, into] : [into, merged];
  const moving = sessions.filter(({ map }) => map === goes);
  const between = points.filter(({ maps }) => maps.includes(stays) && maps.includes(goes) && maps.length === 2).length;
  const others = points.filter(({ maps }) => maps.includes(goes) && !maps.includes(stays)).length;
  const lines = [
    `“${titleOf(goes)}” becomes a part of “${titleOf(stays)}”, and its name leads there.`,
    `${count(moving.length, 'session moves', 'sessions move')} into it; the map is drawn anew from all its sessions.`,
  ];
  if (between > 0) lines.push(`${count(between, 'link point', 'link points')} between the two ${between === 1 ? 'goes' : 'go'}.`);
  if (others > 0) lines.push(`${count(others, 'link point', 'link points')} to other maps ${others === 1 ? 'stays' : 'stay'}.`);
  lines.push('It is one step, and can be undone on the page History as long as the server keeps what that needs.');
  const busy = moving.filter(isOpen).length;
  return { stays, goes, lines, refusal: busy > 0 ? `${count(busy, 'session', 'sessions')} of “${titleOf(goes)}” ${busy === 1 ? 'is' : 'are'} still recorded or mapped: wait until that is over.` : undefined };
}

// Of each session of the map: stays, leaves, or leaves from a record on.
export type Leaving = 'stays' | 'leaves' | bigint;

export function planSplit(map: string, sessions: readonly Session[], leaving: ReadonlyMap<string, Leaving>, titleOf: (name: string) => string): { lines: string[]; refusal: string | undefined } {
  const parts = sessions.map((session) => ({ session, leaves: leaving.get(session.name) ?? 'stays' }));
  const whole = parts.filter(({ leaves }) => leaves === 'leaves');
  const cut = parts.filter(({ leaves }) => typeof leaves === 'bigint');
  const lines: string[] = [];
  if (whole.length > 0) lines.push(`${count(whole.length, 'session leaves', 'sessions leave')} “${titleOf(map)}” for a new map.`);
  if (cut.length > 0) lines.push(`The rest of ${count(cut.length, 'session', 'sessions')} does so as ${cut.length === 1 ? 'a session of its own' : 'sessions of their own'}.`);
  lines.push('Each link point goes with the part whose keyframes are nearest to it, and an opening joins the two maps. It can be undone on the page History.');
  const busy = [...whole, ...cut].filter(({ session }) => isOpen(session)).length;
  const refusal =
    whole.length + cut.length === 0 ? 'Choose at least one session that leaves.'
    : whole.length === sessions.length ? 'One session must stay, or nothing is divided.'
    : busy > 0 ? `${count(busy, 'session', 'sessions')} that would leave ${busy === 1 ? 'is' : 'are'} still recorded or mapped: wait until that is over.`
    : undefined;
  return { lines, refusal };
}

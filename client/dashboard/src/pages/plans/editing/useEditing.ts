// SPDX-License-Identifier: Apache-2.0
// The state of the editor of a plan: its tool, what is selected, and what a person has shown so far.
import { useReducer } from 'react';
import type { Point } from '../../../scene/camera';
import { elementAt, isSame, mayRemove, neighbour, placeOf, snapped, wallsAt, withCornerMoved, withDoor, without, withWall, type Element, type Graph } from './graph';
import { beginning, stepped, type Step, type Steps } from './steps';

export type Tool = 'select' | 'wall' | 'door' | 'measure';

export const tools: readonly { tool: Tool; title: string; key: string; hint: string }[] = [
  { tool: 'select', title: 'Select', key: 'v', hint: 'Click a wall, a door or a corner. Corners are dragged.' },
  { tool: 'wall', title: 'Draw walls', key: 'w', hint: 'Click where a wall begins and where it ends; the next one goes on there. Escape ends it.' },
  { tool: 'door', title: 'Draw a door', key: 'd', hint: 'Click both jambs. A door on a wall makes a gap in it.' },
  { tool: 'measure', title: 'Measure', key: 'm', hint: 'Click two points whose distance you know, and type it.' },
];

export interface Editing {
  steps: Steps;
  tool: Tool;
  selected: Element | undefined;
  // Where a wall, a door or a measure begins.
  first: Point | undefined;
  measured: { from: Point; to: Point } | undefined;
  // The corner that follows the pointer.
  grabbed: Point | undefined;
  // Where the pointer is, or the cross that the arrow keys move.
  at: Point | undefined;
}

// `reach`: units of the sheet within which a click means a corner or a wall; 0: exactly where it is.
export type Act =
  | { kind: 'tool'; tool: Tool }
  | { kind: 'move'; at: Point }
  | { kind: 'click'; at: Point; reach: number }
  | { kind: 'grab'; corner: Point }
  | { kind: 'drop'; at: Point; reach: number }
  | { kind: 'select'; element: Element | undefined }
  | { kind: 'next'; step: 1 | -1 }
  | { kind: 'remove' }
  | { kind: 'cancel' }
  | { kind: 'step'; step: Step };

const idle = { first: undefined, measured: undefined, grabbed: undefined };

export const beginningOf = (graph: Graph): Editing => ({ steps: beginning(graph), tool: 'select', selected: undefined, ...idle, at: undefined });

const inSteps = (state: Editing, step: Step): Editing => ({ ...state, steps: stepped(state.steps, step) });

// Where a point is meant to be. A corner that is moved does not stick to its own walls.
export function meant({ steps: { now }, grabbed }: Editing, at: Point, reach: number): Point {
  if (!grabbed) return snapped(now, at, reach);
  const own = wallsAt(now, grabbed);
  return snapped({ ...now, walls: now.walls.filter((wall) => !own.includes(wall)) }, at, reach);
}

function clicked(state: Editing, at: Point, reach: number): Editing {
  const { steps: { now }, tool, first, selected } = state;
  if (tool === 'select') {
    const element = elementAt(now, at, reach);
    // A corner that is shown twice is taken along, for those who use no pointer.
    if (element?.kind === 'corner' && selected?.kind === 'corner' && isSame(element.at, selected.at)) return { ...state, grabbed: element.at };
    return { ...state, selected: element };
  }
  const place = meant(state, at, reach);
  if (!first) return { ...state, selected: undefined, measured: undefined, first: place };
  if (isSame(first, place)) return { ...state, first: undefined };
  if (tool === 'measure') return { ...state, first: undefined, measured: { from: first, to: place } };
  if (tool === 'door') return { ...inSteps(state, { to: withDoor(now, first, place) }), first: undefined };
  return { ...inSteps(state, { to: withWall(now, first, place) }), first: place };
}

export function edited(state: Editing, act: Act): Editing {
  const { steps: { now }, selected, grabbed } = state;
  switch (act.kind) {
    case 'tool':
      return { ...state, ...idle, tool: act.tool, selected: undefined };
    case 'move':
      return { ...state, at: act.at };
    case 'click':
      return grabbed ? edited(state, { ...act, kind: 'drop' }) : { ...clicked(state, act.at, act.reach), at: act.at };
    case 'grab':
      return { ...state, ...idle, grabbed: act.corner, selected: { kind: 'corner', at: act.corner } };
    case 'drop': {
      if (!grabbed) return state;
      const to = meant(state, act.at, act.reach);
      return { ...inSteps(state, isSame(to, grabbed) ? { to: now } : { to: withCornerMoved(now, grabbed, to) }), grabbed: undefined, selected: { kind: 'corner', at: to } };
    }
    case 'select':
      return { ...state, ...idle, selected: act.element };
    case 'next': {
      const element = neighbour(now, selected, act.step);
      return { ...state, ...idle, tool: 'select', selected: element, at: (element && placeOf(now, element)) ?? state.at };
    }
    case 'remove':
      return selected && mayRemove(now, selected) ? { ...inSteps(state, { to: without(now, selected) }), ...idle, selected: undefined } : state;
    case 'cancel':
      return state.first || state.measured || grabbed ? { ...state, ...idle } : { ...state, selected: undefined };
    case 'step':
      return { ...inSteps(state, act.step), ...idle, selected: undefined };
  }
}

export const useEditing = (begin: () => Editing) => useReducer(edited, undefined, begin);

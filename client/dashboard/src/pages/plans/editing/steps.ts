// SPDX-License-Identifier: Apache-2.0
// A person's steps on a plan that is not saved yet.
import type { Graph } from './graph';

export interface Steps {
  // As it is stored.
  saved: Graph;
  now: Graph;
  done: readonly Graph[];
  undone: readonly Graph[];
}

export type Step = { to: Graph } | 'undo' | 'redo' | 'discard' | { saved: Graph };

export const beginning = (saved: Graph): Steps => ({ saved, now: saved, done: [], undone: [] });

export function stepped(steps: Steps, step: Step): Steps {
  const { now, done, undone } = steps;
  if (step === 'undo') return done.length === 0 ? steps : { ...steps, now: done.at(-1)!, done: done.slice(0, -1), undone: [...undone, now] };
  if (step === 'redo') return undone.length === 0 ? steps : { ...steps, now: undone.at(-1)!, done: [...done, now], undone: undone.slice(0, -1) };
  if (step === 'discard') return beginning(steps.saved);
  if ('saved' in step) return beginning(step.saved);
  return step.to === now ? steps : { ...steps, now: step.to, done: [...done, now], undone: [] };
}

export const isChanged = ({ saved, now }: Steps) => saved !== now;

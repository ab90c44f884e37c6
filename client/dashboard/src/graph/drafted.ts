// SPDX-License-Identifier: Apache-2.0
// A draft with its steps, for undo and redo.
import type { LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import { editOf, emptyDraft, isIdle, laidOn, type Draft, type Edit } from './draft';

export interface Drafted {
  draft: Draft;
  earlier: readonly Draft[];
  later: readonly Draft[];
  // Of the last step: the next one of the same tag, such as of one drag, belongs to it.
  tag: string;
}

export const nothingDrafted: Drafted = { draft: emptyDraft, earlier: [], later: [], tag: '' };

export type Step =
  | { edits: readonly Edit[]; tag?: string }
  // Forgets the edits of one link point.
  | { drop: string }
  // Lays the edits on what the server has now.
  | { theirs: LinkPoint }
  | 'undo'
  | 'redo'
  | 'forget';

function put(draft: Draft, edits: readonly Edit[]): Draft {
  const next = new Map(draft);
  for (const edit of edits) {
    if (isIdle(edit)) next.delete(edit.base.name);
    else next.set(edit.base.name, edit);
  }
  return next;
}

function laidOnTheirs(draft: Draft, theirs: LinkPoint): Draft {
  const edit = draft.get(theirs.name);
  return edit && !edit.isNew ? put(draft, [laidOn(edit, theirs)]) : draft;
}

function without(draft: Draft, name: string): Draft {
  const next = new Map(draft);
  next.delete(name);
  return next;
}

export function stepped(state: Drafted, step: Step): Drafted {
  const { draft, earlier, later } = state;
  if (step === 'forget') return nothingDrafted;
  if (step === 'undo') return earlier.length === 0 ? state : { draft: earlier.at(-1)!, earlier: earlier.slice(0, -1), later: [draft, ...later], tag: '' };
  if (step === 'redo') return later.length === 0 ? state : { draft: later[0]!, earlier: [...earlier, draft], later: later.slice(1), tag: '' };
  if ('drop' in step) {
    // It would come back onto what is no longer there.
    return { draft: without(draft, step.drop), earlier: earlier.map((one) => without(one, step.drop)), later: [], tag: '' };
  }
  if ('theirs' in step) {
    const lay = (one: Draft) => laidOnTheirs(one, step.theirs);
    return { draft: lay(draft), earlier: earlier.map(lay), later: later.map(lay), tag: '' };
  }
  const next = put(draft, step.edits);
  const isSame = step.tag !== undefined && step.tag === state.tag;
  return { draft: next, earlier: isSame ? earlier : [...earlier, draft], later: [], tag: step.tag ?? '' };
}

// What is wanted of a link point, or what it is.
export const currentEdit = (draft: Draft, base: LinkPoint): Edit => draft.get(base.name) ?? editOf(base);

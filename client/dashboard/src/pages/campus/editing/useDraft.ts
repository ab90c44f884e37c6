// SPDX-License-Identifier: Apache-2.0
import { useCallback, useEffect, useMemo, useReducer } from 'react';
import { type Edit } from '../../../graph/draft';
import { nothingDrafted, stepped, type Drafted } from '../../../graph/drafted';

// By site: who looks at another page finds the draft as it was.
const kept = new Map<string, Drafted>();

// What is being changed, with its steps.
export function useDraft(site: string) {
  const [state, step] = useReducer(stepped, site, (id) => kept.get(id) ?? nothingDrafted);
  const { draft, earlier, later } = state;
  useEffect(() => void kept.set(site, state), [site, state]);
  const put = useCallback((edit: Edit, tag?: string) => step({ edits: [edit], ...(tag !== undefined && { tag }) }), []);
  return useMemo(() => ({ draft, step, put, canUndo: earlier.length > 0, canRedo: later.length > 0 }), [draft, earlier, later, put]);
}

export type Drafting = ReturnType<typeof useDraft>;

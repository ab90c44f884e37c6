// SPDX-License-Identifier: Apache-2.0
import { useEffect, useMemo, useRef, useState } from 'react';
import { graphs } from '../../../api/clients';
import { siteName } from '../../../api/names';
import { changesOf, type Draft } from '../../../graph/draft';
import { Latest } from '../../../graph/latest';
import { effectsOf, type Effects } from '../../../graph/preview';
import type { LiveSite } from '../../../live/site';

export interface Preview {
  // Undefined: there is nothing to preview, or nothing has come yet.
  effects: Effects | undefined;
  error: unknown;
  // It is that of the draft as it is now.
  isCurrent: boolean;
}

interface Told {
  draft: Draft;
  effects: Effects | undefined;
  error: unknown;
}

const nothing: Preview = { effects: undefined, error: undefined, isCurrent: true };

// What the draft would do, asked anew with every change of it and every version of the graph. `onlyVersion`: while a hand
// drags, answers from another version of the graph are not shown. `isSaving`: nothing is asked, since the etags are about to change.
export function usePreview(site: LiveSite, draft: Draft, graphVersion: bigint, onlyVersion: bigint | undefined, isSaving: boolean): Preview {
  const [told, setTold] = useState<Told>();
  const only = useRef(onlyVersion);
  only.current = onlyVersion;
  const latest = useMemo(() => new Latest(
    async (asked: Draft) => effectsOf(await graphs.previewGraph({ site: siteName(site.id), changes: changesOf(asked) }), (map) => site.maps.get(map)?.poseWorldMap !== undefined),
    (asked, effects, error) => {
      if (effects && only.current !== undefined && effects.graphVersion !== only.current) return;
      setTold((before) => ({ draft: asked, effects: effects ?? before?.effects, error }));
    },
  ), [site]);
  useEffect(() => () => latest.withdraw(), [latest]);
  const isEmpty = draft.size === 0;
  useEffect(() => {
    if (isEmpty) {
      latest.withdraw();
      setTold(undefined);
    } else if (!isSaving) {
      latest.want(draft);
    }
  }, [latest, draft, isEmpty, graphVersion, onlyVersion, isSaving]);
  if (isEmpty || !told) return { ...nothing, isCurrent: isEmpty };
  return { effects: told.effects, error: told.error, isCurrent: told.draft === draft };
}

// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useCallback, useMemo, useState } from 'react';
import { graphs, linkPoints } from '../../../api/clients';
import { siteName } from '../../../api/names';
import { select } from '../../../app/selection';
import { linkPointOfFit } from '../../../graph/alignment';
import { anchorOf, anchorsOf, changesOf, editOf, movedTo, spreadTo, type AnchorPlace } from '../../../graph/draft';
import { currentEdit } from '../../../graph/drafted';
import { kindNames } from '../../../graph/differences';
import type { Handle } from '../../../graph/handles';
import { byHand, covarianceOf } from '../../../graph/spread';
import type { AlignMapsResponse } from '../../../gen/enfilade/v1/graph_service_pb';
import { LinkPointSchema, LinkPoint_Kind as Kind, LinkPoint_Use as Use, type LinkPoint } from '../../../gen/enfilade/v1/link_point_pb';
import { distinctTitleOf } from '../../../live/objects';
import type { LiveSite } from '../../../live/site';
import type { Pose } from '../../../scene/camera';
import { middleAt } from '../../../scene/moves';
import { chained, relative } from '../../../scene/se2';
import { sharedScene } from '../../../scene/shared';
import { conflictsOf } from './Conflicts';
import { frameOf, hold as heldNow, viewOfDraft, viewOfPair, type Held } from './editorView';
import { useAlign } from './useAlign';
import { useDraft } from './useDraft';
import { linkPointKey, useLinkPoints } from './useLinkPoints';
import { usePreview } from './usePreview';

// Plain http has no randomUUID.
const newId = () => `hand-${Array.from(crypto.getRandomValues(new Uint8Array(8)), (byte) => byte.toString(16).padStart(2, '0')).join('')}`;

const origin: Pose = { x: 0, y: 0, yaw: 0 };
const noAnchors: ReadonlyMap<string, AnchorPlace> = new Map();

// The middle of what has been seen of a map, in its frame.
const middleOf = (map: string): Pose => ({ ...middleAt(origin, sharedScene()?.thumbnails.get(map)), yaw: 0 });

// All that the editor of the graph knows: what is selected, what is changed, and what that would do.
export function useEditor(live: LiveSite, level: number | undefined, selected: string | undefined) {
  const queries = useQueryClient();
  const drafting = useDraft(live.id);
  const { draft, put, step } = drafting;
  const align = useAlign(live);
  const [held, setHeld] = useState<Held>();
  const [chosen, setChosen] = useState<string>();

  const isLinkPoint = selected !== undefined && /\/linkPoints\//.test(selected);
  const names = [...new Set([...[...draft].flatMap(([name, { isNew }]) => (isNew ? [] : [name])), ...(isLinkPoint && !draft.get(selected)?.isNew ? [selected] : [])])];
  const present = useLinkPoints(live, names);
  const conflicts = held ? [] : conflictsOf(draft, present);

  const save = useMutation({
    mutationFn: () => graphs.changeGraph({ site: siteName(live.id), changes: changesOf(draft) }),
    onSuccess: ({ linkPoints: stored }) => {
      // Deleted ones are not read again: the stream tells of them a moment later.
      for (const [name, { isDeleted }] of draft) if (isDeleted) queries.setQueriesData({ queryKey: linkPointKey(name) }, null);
      for (const one of stored) queries.setQueriesData({ queryKey: linkPointKey(one.name) }, one);
      step('forget');
    },
    onError: () => queries.invalidateQueries({ queryKey: ['linkPoint'] }),
  });

  const preview = usePreview(live, draft, live.graphVersion, held?.version, save.isPending);

  const titleOf = useCallback((name: string) => {
    const edit = draft.get(name);
    return edit?.isNew ? `New ${kindNames[edit.base.kind].toLowerCase()} ${[...anchorsOf(edit).keys()].map((map) => distinctTitleOf(live, map)).join(' – ')}` : distinctTitleOf(live, name);
  }, [live, draft]);

  // What has been made here, until the stream tells of it.
  const made = save.data && live.graphVersion < save.data.graphVersion ? save.data.linkPoints.find(({ name }) => name === selected) : undefined;
  const base = isLinkPoint ? (present.get(selected) ?? made) : undefined;
  const edit = isLinkPoint ? (draft.get(selected) ?? (base && currentEdit(draft, base))) : undefined;
  const anchors = edit ? anchorsOf(edit) : noAnchors;
  const inWorld = [...anchors.keys()].find((map) => frameOf(live, held, map) !== undefined && map !== live.rootMap);
  const active = chosen !== undefined && anchors.has(chosen) ? chosen : (inWorld ?? [...anchors.keys()][0]);
  const shown = [...anchors].flatMap(([map, place]) => {
    const frame = frameOf(live, held, map);
    return frame ? [{ map, title: titleOf(map), place, frame }] : [];
  });

  const { graphRevision } = live;
  const { effects } = preview;
  const pairView = useMemo(() => align.pair && viewOfPair(live, align.pair), [live, align.pair, graphRevision]);
  const draftView = useMemo(() => viewOfDraft({ site: live, level, selected, held, effects, anchors: effects && edit ? anchorsOf(edit) : noAnchors }), [live, level, selected, held, effects, edit, graphRevision]);

  const begin = (linkPoint: LinkPoint) => {
    put({ base: linkPoint, isNew: true, anchors: {} });
    select(linkPoint.name);
  };
  return {
    drafting, align, held, preview, conflicts, titleOf, save,
    // A draft of which it is known what it would do, or that the server has refused.
    maySave: draft.size > 0 && !held && !save.isPending && (preview.isCurrent && (effects !== undefined || preview.error !== undefined)),
    selection: edit && { edit, active, shown },
    isGone: isLinkPoint && present.get(selected) === null && !edit,
    view: pairView ?? draftView,
    base: pairView?.base ?? origin,
    choose: setChosen,
    hold: (on: boolean) => setHeld(on ? heldNow(live) : undefined),
    change(map: string, handle: Handle, { pose, covariance }: { pose: Pose; covariance: number[] }, tag: string) {
      if (edit) put(handle === 'middle' || handle === 'heading' ? movedTo(edit, map, pose) : spreadTo(edit, map, covariance), tag);
    },
    // A candidate in the middle of a map.
    createIn(map: string) {
      const name = `${siteName(live.id)}/linkPoints/${newId()}`;
      begin(create(LinkPointSchema, { name, kind: Kind.DOOR, anchors: [anchorOf(map, { pose: middleOf(map), covariance: covarianceOf(byHand) })] }));
    },
    makeOfFit(answer: AlignMapsResponse) {
      if (!align.pair) return;
      const made = linkPointOfFit(`${siteName(live.id)}/linkPoints/${newId()}`, align.pair.a, align.pair.b, answer);
      if (!made) return;
      align.end();
      begin(made);
    },
    // Where the selected place would be in another map: as the world has it, or in its middle.
    guess(map: string): Pose {
      const from = shown[0];
      const frame = frameOf(live, held, map);
      return from && frame ? relative(frame, chained(from.frame, from.place.pose)) : middleOf(map);
    },
    // Takes an existing link point out of the graph with the next save; undefined: it is out already.
    suspend(name: string): (() => void) | undefined {
      const known = draft.get(name);
      if (known?.isNew || known?.isDeleted || known?.use !== undefined || !live.linkPoints.has(name) || live.linkPoints.get(name)?.use === Use.SUSPENDED) return undefined;
      if (known) return () => put({ ...known, use: 'suspended' });
      return () => void linkPoints.getLinkPoint({ name }).then(({ linkPoint }) => linkPoint && put({ ...editOf(linkPoint), use: 'suspended' }));
    },
    forget(name: string) {
      step({ drop: name });
      void queries.invalidateQueries({ queryKey: linkPointKey(name) });
    },
  };
}

export type Editor = ReturnType<typeof useEditor>;

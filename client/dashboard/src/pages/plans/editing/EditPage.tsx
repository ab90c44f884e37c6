// SPDX-License-Identifier: Apache-2.0
import './board.css';
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { useEffect, useRef, useState } from 'react';
import { priorMaps } from '../../../api/clients';
import { idOf } from '../../../api/names';
import { addressOf, Link } from '../../../app/router';
import type { PriorMap } from '../../../gen/enfilade/v1/prior_map_pb';
import { useLive } from '../../../live/context';
import { plansKey } from '../../../live/plans';
import { filesAt } from '../../../ui/FileLinks';
import { count } from '../../../ui/format';
import { Question } from '../../../ui/Question';
import { refusalOf } from '../../../ui/Sending';
import { Failed, Loading } from '../../../ui/States';
import { isPicture } from '../plans';
import { Board, type Frame } from './Board';
import { changesText } from './changes';
import { Details, textOf } from './Details';
import { boundsOf, graphOf, toGeoJson } from './graph';
import { readPlanText, textKey } from './planText';
import { isChanged } from './steps';
import { beginningOf, tools, useEditing, type Editing } from './useEditing';

// What is not saved yet stays until the page is loaded again, by the plan's name.
const drafts = new Map<string, { text: string; state: Editing }>();

function Tools({ state, act }: { state: Editing; act: ReturnType<typeof useEditing>[1] }) {
  const { done, undone } = state.steps;
  return (
    <div className="board-tools" role="toolbar" aria-label="Tools">
      {tools.map(({ tool, title, key }) => (
        <button key={tool} className="button" aria-pressed={state.tool === tool} aria-keyshortcuts={key} title={`${title} (${key})`} onClick={() => act({ kind: 'tool', tool })}>
          {title}
        </button>
      ))}
      <span className="space" />
      <button className="button" disabled={done.length === 0} aria-keyshortcuts="Control+Z" onClick={() => act({ kind: 'step', step: 'undo' })}>
        Undo
      </button>
      <button className="button" disabled={undone.length === 0} aria-keyshortcuts="Control+Y" onClick={() => act({ kind: 'step', step: 'redo' })}>
        Redo
      </button>
    </div>
  );
}

interface Loaded {
  plan: PriorMap;
  // The plan.geojson of this etag.
  text: string;
  picture: { src: string; frame: Frame } | undefined;
}

function Editor({ plan, text, picture }: Loaded) {
  const live = useLive();
  const queries = useQueryClient();
  const [base, setBase] = useState(drafts.get(plan.name)?.text ?? text);
  const [state, act] = useEditing(() => drafts.get(plan.name)?.state ?? beginningOf(graphOf(JSON.parse(text))));
  const changed = isChanged(state.steps);
  const somebodyElse = text !== base && changed;
  const save = useMutation({
    mutationFn: async () => {
      const response = await priorMaps.editPriorMap({ name: plan.name, plan: toGeoJson(state.steps.now), etag: plan.etag });
      const stored = response.priorMap!;
      return { ...response, text: await queries.fetchQuery({ queryKey: textKey(stored), staleTime: Infinity, queryFn: () => readPlanText(stored) }) };
    },
    onSuccess: ({ text: stored }) => begin(stored),
    onSettled: () => queries.invalidateQueries({ queryKey: plansKey(live.id) }),
  });
  const begin = (stored: string) => {
    setBase(stored);
    act({ kind: 'step', step: { saved: graphOf(JSON.parse(stored)) } });
  };
  useEffect(() => {
    if (changed) drafts.set(plan.name, { text: base, state });
    else drafts.delete(plan.name);
  }, [plan.name, base, state, changed]);
  // Somebody else has corrected it, and nothing of here is lost.
  useEffect(() => {
    if (text !== base && !changed && !save.isPending) begin(text);
  });

  const maySave = changed && !somebodyElse && !save.isPending;
  const onKey = (event: KeyboardEvent) => {
    if (event.defaultPrevented || event.altKey || (event.target instanceof HTMLElement && event.target.closest('input, select, textarea, dialog') !== null)) return;
    const key = event.key.toLowerCase();
    const tool = tools.find((one) => one.key === key);
    if (event.ctrlKey || event.metaKey) {
      if (key === 's') maySave && save.mutate();
      else if (key === 'z' || key === 'y') act({ kind: 'step', step: key === 'y' || event.shiftKey ? 'redo' : 'undo' });
      else return;
    } else if (tool) act({ kind: 'tool', tool: tool.tool });
    else if (key === 'delete' || key === 'backspace') act({ kind: 'remove' });
    else if (key === 'escape') act({ kind: 'cancel' });
    else return;
    event.preventDefault();
  };
  // Wherever the focus is.
  useEffect(() => {
    window.addEventListener('keydown', onKey);
    return () => window.removeEventListener('keydown', onKey);
  });

  const board = useRef<HTMLDivElement>(null);
  const { now } = state.steps;
  const [frame] = useState(() => picture?.frame ?? frameOf(now));
  return (
    <div className="plan-editor">
      <div className="plan-board">
        <Tools state={state} act={act} />
        <Board state={state} act={act} frame={frame} picture={picture?.src} said={textOf(now, state.selected)} board={board} />
      </div>
      <aside className="panel" aria-label="Details">
        <h1>Walls of {plan.displayName}</h1>
        <p className="sub">{count(now.walls.length, 'wall')}, {count(now.doors.length, 'door')}; {now.metresPerUnit === undefined ? 'the scale is unknown' : `${now.metresPerUnit.toPrecision(4)} m per unit`}</p>
        <Details state={state} act={act} leave={() => board.current?.focus()} />
        <div className="actions">
          <button className="button primary" disabled={!maySave} aria-keyshortcuts="Control+S" onClick={() => save.mutate()}>
            Save
          </button>
          {changed && <Question title="Discard" question="Discard all that is not saved?" yes="Discard it" no="Keep it" busy={save.isPending} act={() => begin(text)} />}
          <Link className="button" href={addressOf(live.id, 'plans', [idOf(plan.name)])}>
            Back to the plan
          </Link>
        </div>
        {plan.alignment && changed && <p className="sub">What is saved is out of use until the plan is aligned again.</p>}
        {somebodyElse && <p className="refusal" role="alert">Somebody has corrected this plan meanwhile. Discard yours to see it.</p>}
        {save.isPending && <p role="status">Saving …</p>}
        {save.error && changed && <p className="refusal" role="alert">{refusalOf(save.error)}</p>}
        {save.data && !changed && (
          <div role="status">
            <p>Saved: {changesText(save.data.changes)}.{plan.alignment && ' Align it again.'}</p>
            <ul>
              {save.data.warnings.map((warning) => (
                <li key={warning}>{warning}</li>
              ))}
            </ul>
          </div>
        )}
      </aside>
    </div>
  );
}

function frameOf(graph: Parameters<typeof boundsOf>[0]): Frame {
  const { minX, minY, maxX, maxY } = boundsOf(graph) ?? { minX: 0, minY: 0, maxX: 1, maxY: 1 };
  const margin = 0.04 * Math.max(maxX - minX, maxY - minY);
  return { x: minX - margin, y: minY - margin, width: maxX - minX + 2 * margin, height: maxY - minY + 2 * margin };
}

// The origin of the sheet is the centre of the top left pixel.
async function pictureOf(plan: PriorMap): Promise<Loaded['picture'] | null> {
  if (!isPicture(plan)) return null;
  const src = (await filesAt(`/v1/${plan.name}/files?product=sheet`))[0]?.path;
  if (src === undefined) return null;
  const image = new Image();
  image.src = src;
  await image.decode();
  return { src, frame: { x: -0.5, y: -0.5, width: image.naturalWidth, height: image.naturalHeight } };
}

// A person corrects the walls of a plan.
export function EditPage({ plan }: { plan: PriorMap }) {
  const text = useQuery({ queryKey: textKey(plan), staleTime: Infinity, placeholderData: (earlier: string | undefined) => earlier, queryFn: () => readPlanText(plan) });
  const picture = useQuery({ queryKey: ['planPicture', plan.name], staleTime: Infinity, queryFn: () => pictureOf(plan) });
  const error = text.error ?? picture.error;
  if (error) return <Failed error={error} retry={() => void Promise.all([text.refetch(), picture.refetch()])} />;
  if (text.data === undefined || picture.data === undefined) return <Loading />;
  return <Editor plan={plan} text={text.data} picture={picture.data ?? undefined} />;
}

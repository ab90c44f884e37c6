// SPDX-License-Identifier: Apache-2.0
import { select } from '../../../app/selection';
import { useLive } from '../../../live/context';
import { Icon } from '../../../ui/Icon';
import { Loading } from '../../../ui/States';
import { LinkPointForm } from './LinkPointForm';
import { MapForm } from './MapForm';
import type { Editor } from './useEditor';

// What is selected, and what can be changed of it.
export function SelectionForm({ editor, selected }: { editor: Editor; selected: string | undefined }) {
  const live = useLive();
  const { selection, drafting: { draft, put }, titleOf } = editor;
  if (selected === undefined) {
    return <p className="sub">Choose a link point to move it, or a map to make link points in it, to align it with another one, to merge or to split it: on the map, or in the list below.</p>;
  }
  const isMap = live.maps.has(selected);
  return (
    <section className="inspector" aria-label="Selection">
      <div className="inspector-head">
        <Icon name={isMap ? 'map' : 'link'} />
        <div className="inspector-title">
          <h1>{titleOf(selected)}</h1>
        </div>
        <button className="button icon plain" aria-label="Close" title="Close (Esc)" onClick={() => select(undefined)}>
          <Icon name="close" />
        </button>
      </div>
      {isMap ? (
        <MapForm key={selected} map={selected} create={() => editor.createIn(selected)} align={(other) => editor.align.begin(selected, other)} isDrafting={draft.size > 0} />
      ) : selection ? (
        <LinkPointForm edit={selection.edit} put={put} active={selection.active} choose={editor.choose} guess={editor.guess} />
      ) : editor.isGone ? (
        <p className="sub">This link point is not there any more. Close this and choose another one.</p>
      ) : (
        <Loading rows={4} />
      )}
    </section>
  );
}

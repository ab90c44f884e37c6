// SPDX-License-Identifier: Apache-2.0
import { useSyncExternalStore } from 'react';
import { scaleBar } from '../campus/Readout';
import { cellText } from '../../edit/words';
import type { EditorState } from './useEditor';

// Where the pointer is, the scale, and what the editor has to say. It changes with the pointer, so it is a component of its own.
export function Status({ editor }: { editor: EditorState }) {
  const { board, session } = editor;
  const pointer = useSyncExternalStore(editor.pointerMoved.subscribe, () => editor.pointer);
  const scale = useSyncExternalStore(board.cameraChanged.subscribe, () => board.camera.scale);
  const bar = scaleBar(scale / session.frame.resolution);
  const metres = pointer && session.frame.metres(pointer);
  const { all, left } = session.tiles.progress;
  return (
    <div className="scene-status">
      <div className="scale-bar" style={{ width: bar.pixels }}>
        {bar.metres >= 1 ? `${bar.metres} m` : `${Math.round(bar.metres * 100)} cm`}
      </div>
      <span className="scene-chip mono">{metres && `x ${metres.x.toFixed(2)}  y ${metres.y.toFixed(2)} m`}</span>
      <span className="scene-chip mono">{pointer && `cell ${Math.floor(pointer.x)}, ${Math.floor(pointer.y)}: ${cellText(session.draft.overlay.at(Math.floor(pointer.y), Math.floor(pointer.x)))}`}</span>
      <span className="scene-chip">{left > 0 && `${all - left} of ${all} tiles loaded`}</span>
      <span className="scene-chip" role="status">
        {editor.said || session.tilesFailed}
      </span>
    </div>
  );
}

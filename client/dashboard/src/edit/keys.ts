// SPDX-License-Identifier: Apache-2.0
// The editor's keys. Letters act wherever the focus is, but for fields and dialogs.
import { CLEAR, FREE, OCCUPIED, UNKNOWN } from './cells';
import type { Board } from './board/Board';
import type { ToolName } from './tools/settings';

export const toolKeys: Record<ToolName, string> = { brush: 'b', line: 'l', rectangle: 'r', polygon: 'g', fill: 'f', area: 'a' };
export const valueKeys = { [FREE]: '1', [OCCUPIED]: '2', [UNKNOWN]: '3', [CLEAR]: '4' } as const;

const isTyping = (target: EventTarget | null) => target instanceof HTMLElement && target.closest('input:not([type=checkbox], [type=radio]), select, textarea, dialog, [contenteditable]') !== null;
const isControl = (target: EventTarget | null) => target instanceof HTMLElement && target.closest('button, a, summary, input') !== null;

export interface KeyActions {
  board: Board;
  publish(): void;
  undone(what: string): void;
}

function withControl(key: string, isShifted: boolean, { board, publish, undone }: KeyActions): boolean {
  if (key === 's') publish();
  else if (key === 'z' && !isShifted) undone(board.session.undo() ? 'Undone.' : 'There is nothing of yours to undo.');
  else if (key === 'y' || key === 'z') undone(board.session.redo() ? 'Done again.' : 'There is nothing to do again.');
  else return false;
  return true;
}

function plain(key: string, { board }: KeyActions): boolean {
  const { settings } = board;
  const tool = (Object.keys(toolKeys) as ToolName[]).find((name) => toolKeys[name] === key);
  const value = ([FREE, OCCUPIED, UNKNOWN, CLEAR] as const).find((one) => valueKeys[one] === key);
  if (tool) {
    board.cancel();
    settings.set({ tool });
  } else if (value) settings.set({ value });
  else if (key === '[') settings.resize(-1);
  else if (key === ']') settings.resize(1);
  else if (key === 'x') settings.swap();
  else if (key === 'escape') board.cancel();
  else if (key === 'backspace') board.back();
  else return false;
  return true;
}

// Returns what ends it.
export function listenToKeys(actions: KeyActions): () => void {
  const onDown = (event: KeyboardEvent) => {
    if (event.defaultPrevented || event.altKey || isTyping(event.target)) return;
    const key = event.key.toLowerCase();
    let isUsed: boolean;
    if (event.ctrlKey || event.metaKey) isUsed = withControl(key, event.shiftKey, actions);
    else if (key === ' ' || key === 'enter') {
      if (isControl(event.target)) return;
      if (key === ' ') actions.board.space = true;
      else actions.board.finish();
      isUsed = true;
    } else isUsed = plain(key, actions);
    if (isUsed) event.preventDefault();
  };
  const onUp = (event: KeyboardEvent) => {
    if (event.key === ' ') actions.board.space = false;
  };
  window.addEventListener('keydown', onDown);
  window.addEventListener('keyup', onUp);
  return () => {
    window.removeEventListener('keydown', onDown);
    window.removeEventListener('keyup', onUp);
  };
}

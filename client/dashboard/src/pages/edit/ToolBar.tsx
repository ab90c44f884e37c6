// SPDX-License-Identifier: Apache-2.0
import { toolKeys } from '../../edit/keys';
import type { ToolName } from '../../edit/tools/settings';
import { toolNames } from '../../edit/words';
import { ToolButton } from '../../scene/SceneView';
import type { EditorState } from './useEditor';

// What the pointer draws.
export function ToolBar({ editor }: { editor: EditorState }) {
  const { settings, board } = editor;
  const choose = (tool: ToolName) => {
    board.cancel();
    settings.set({ tool });
  };
  return (
    <div className="scene-tools edit-tools" role="toolbar" aria-label="Tools">
      {(Object.keys(toolNames) as ToolName[]).map((tool) => (
        <ToolButton key={tool} icon={tool} title={toolNames[tool]} keys={toolKeys[tool]} pressed={settings.get().tool === tool} onClick={() => choose(tool)} />
      ))}
    </div>
  );
}

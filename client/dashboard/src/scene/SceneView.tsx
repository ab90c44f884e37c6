// SPDX-License-Identifier: Apache-2.0
import './scene.css';
import { useEffect, useRef, useState, type ReactNode } from 'react';
import { useLive } from '../live/context';
import { Icon, type IconName } from '../ui/Icon';
import { Empty } from '../ui/States';
import { Composite } from './Composite';
import type { View } from './model';
import type { SceneEvents } from './Scene';
import { sharedScene } from './shared';

export function ToolButton({ icon, title, keys, pressed, onClick }: { icon: IconName; title: string; keys?: string; pressed?: boolean; onClick: () => void }) {
  return (
    <button className="button icon tool" title={keys === undefined ? title : `${title} (${keys})`} aria-label={title} aria-keyshortcuts={keys} aria-pressed={pressed} onClick={onClick}>
      <Icon name={icon} />
    </button>
  );
}

// Mostly it comes back within seconds; where it does not, only loading the page again helps.
function LostContext() {
  return (
    <div className="scene-lost">
      <Empty title="The graphics card has dropped the map">
        This happens when the computer wakes up, or when other programs need the card. The map is drawn again as soon as the browser gives it back;
        the lists go on. If it does not come back, load the page again.
      </Empty>
      <button className="button" onClick={() => location.reload()}>
        Load again
      </button>
    </div>
  );
}

// The picture of the site on the shared canvas, with `children` over it. Zoom buttons are always there; `tools` go below.
export function SceneView({ view, events, tools, children }: { view: View; events?: SceneEvents; tools?: ReactNode; children?: ReactNode }) {
  const live = useLive();
  const host = useRef<HTMLDivElement>(null);
  const scene = sharedScene();
  const [lost, setLost] = useState(scene?.lost ?? false);

  useEffect(() => {
    if (!scene || !host.current) return;
    host.current.append(scene.canvas, scene.labels.element);
    scene.show(live);
    return () => {
      scene.canvas.remove();
      scene.labels.element.remove();
      scene.events = {};
    };
  }, [scene, live]);
  useEffect(() => {
    scene?.look(view);
    if (scene) scene.events = { ...events, lost: setLost, key: (key) => (key === '0' ? scene.fit() : (events?.key?.(key) ?? false)) };
  });

  if (!scene) {
    return (
      <div className="scene">
        <Composite view={view} />
      </div>
    );
  }
  return (
    <div className="scene">
      <div className="scene-host" ref={host} />
      {lost && <LostContext />}
      <div className="scene-tools" role="toolbar" aria-label="Map">
        <ToolButton icon="plus" title="Zoom in" keys="+" onClick={() => scene.zoom(1.5)} />
        <ToolButton icon="minus" title="Zoom out" keys="-" onClick={() => scene.zoom(1 / 1.5)} />
        <ToolButton icon="fit" title="Show all" keys="0" onClick={() => scene.fit()} />
        {tools}
      </div>
      {children}
    </div>
  );
}

// SPDX-License-Identifier: Apache-2.0
import type { AnchorPlace } from '../../../graph/draft';
import { covarianceOf, presets, SMALLEST_M, SMALLEST_RAD, spreadOf, tidied, LARGEST_M, type Spread } from '../../../graph/spread';
import type { Pose } from '../../../scene/camera';
import { wrapped } from '../../../scene/se2';
import { NumberField } from './NumberField';

const DEG = 180 / Math.PI;

interface Props {
  title: string;
  place: AnchorPlace;
  move: (pose: Pose, tag: string) => void;
  spread: (covariance: number[], tag?: string) => void;
}

// An anchor in numbers: where it is, and how exactly that is known.
export function AnchorForm({ title, place: { pose, covariance }, move, spread }: Props) {
  const known = spreadOf(covariance);
  const set = (part: Partial<Spread>, tag: string) => spread(covarianceOf(tidied({ ...known, ...part })), tag);
  const isPreset = (one: Spread) => covarianceOf(one).every((value, i) => Math.abs(value - (covariance[i] ?? 0)) < 1e-12);
  return (
    <div className="anchor-form" role="group" aria-label={`Anchor in ${title}`}>
      <div className="numbers">
        <NumberField label="x, m" value={pose.x} digits={4} step={0.05} onChange={(x) => move({ ...pose, x }, `${title} x`)} />
        <NumberField label="y, m" value={pose.y} digits={4} step={0.05} onChange={(y) => move({ ...pose, y }, `${title} y`)} />
        <NumberField label="Direction, °" value={pose.yaw * DEG} digits={3} step={1} onChange={(yaw) => move({ ...pose, yaw: wrapped(yaw / DEG) }, `${title} yaw`)} />
      </div>
      <p className="sub">How exactly it is known (1 σ)</p>
      <div className="numbers">
        <NumberField label="σ longer axis, m" value={known.major} digits={4} step={0.01} min={SMALLEST_M} max={LARGEST_M} onChange={(major) => set({ major }, `${title} major`)} />
        <NumberField label="σ shorter axis, m" value={known.minor} digits={4} step={0.01} min={SMALLEST_M} max={LARGEST_M} onChange={(minor) => set({ minor }, `${title} minor`)} />
        <NumberField label="Longer axis at, °" value={known.angle * DEG} digits={2} step={5} onChange={(angle) => set({ angle: angle / DEG }, `${title} angle`)} />
        <NumberField label="σ direction, °" value={known.yaw * DEG} digits={3} step={0.5} min={SMALLEST_RAD * DEG} max={180} onChange={(yaw) => set({ yaw: yaw / DEG }, `${title} wedge`)} />
      </div>
      <div className="presets" role="group" aria-label="Presets">
        {presets.map((preset) => (
          <button key={preset.title} className="button" aria-pressed={isPreset(preset.spread)} onClick={() => spread(covarianceOf(preset.spread))}>
            {preset.title}
          </button>
        ))}
      </div>
    </div>
  );
}

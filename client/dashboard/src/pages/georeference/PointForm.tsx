// SPDX-License-Identifier: Apache-2.0
import { useEffect, useState, type FormEvent } from 'react';
import { useLive } from '../../live/context';
import { byName } from '../../ui/format';
import { parseLatLon, type Control } from './draft';

// Where the person has clicked.
export interface Chosen {
  map: string;
  x: number;
  y: number;
}

const fields = ['x', 'y', 'latitude', 'longitude'] as const;
type Field = (typeof fields)[number];

const titles: Record<Field, string> = { x: 'x in the map, m', y: 'y in the map, m', latitude: 'Latitude, °', longitude: 'Longitude, °' };
const nothing: Record<Field, string> = { x: '', y: '', latitude: '', longitude: '' };

// Both coordinates may be in the field of the latitude, as other maps copy them.
function split(texts: Record<Field, string>): Record<Field, string> {
  const both = parseLatLon(texts.latitude);
  return both ? { ...texts, latitude: String(both.latitude), longitude: String(both.longitude) } : texts;
}

// A control point: its place by a click on the map or by numbers, and its latitude and longitude.
export function PointForm({ chosen, add }: { chosen: Chosen | undefined; add: (control: Control) => void }) {
  const live = useLive();
  const [map, setMap] = useState('');
  const [texts, setTexts] = useState(nothing);
  const [problem, setProblem] = useState('');
  useEffect(() => {
    if (!chosen) return;
    setMap(chosen.map);
    setTexts((before) => ({ ...before, x: chosen.x.toFixed(2), y: chosen.y.toFixed(2) }));
  }, [chosen]);

  const write = (field: Field, text: string) => setTexts((before) => ({ ...before, [field]: text }));
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    const all = split(texts);
    const numbers = fields.map((field) => (all[field].trim() === '' ? NaN : Number(all[field])));
    const wrong = fields.filter((_, i) => !Number.isFinite(numbers[i]));
    if (map === '') return setProblem('Choose a map, or click on one.');
    if (wrong.length > 0) return setProblem(`Not a number: ${wrong.map((field) => titles[field].split(',')[0]).join(', ')}.`);
    const [x, y, latitude, longitude] = numbers as [number, number, number, number];
    setProblem('');
    add({ map, x, y, latitude, longitude });
    setTexts(nothing);
  };
  const placed = [...live.maps.values()].filter(({ poseWorldMap }) => poseWorldMap).sort((a, b) => byName(a.displayName, b.displayName));
  return (
    <form className="point-form" onSubmit={onSubmit} noValidate aria-label="New control point">
      <p className="sub">Click a place on the map whose latitude and longitude you know, such as the corner of a building, or enter its coordinates.</p>
      <label>
        Map
        <select className="select" value={map} onChange={(event) => setMap(event.target.value)}>
          <option value="">choose a map</option>
          {placed.map((one) => (
            <option key={one.map} value={one.map}>
              {one.displayName}
            </option>
          ))}
        </select>
      </label>
      {fields.map((field) => (
        <label key={field}>
          {titles[field]}
          <input className="field" inputMode="decimal" value={texts[field]} onChange={(event) => write(field, event.target.value)} onBlur={() => setTexts(split)} placeholder={field === 'latitude' ? 'or both: 50.7744, 6.0786' : ''} />
        </label>
      ))}
      {problem !== '' && <p className="refusal" role="alert">{problem}</p>}
      <button className="button">Add the point</button>
    </form>
  );
}

// SPDX-License-Identifier: Apache-2.0
// Numbers and times for people: one form each on all pages.

// The order in which people look for names: r2 before r10.
export const byName = new Intl.Collator(undefined, { numeric: true }).compare;

export const metres = (value: number) => (Number.isFinite(value) ? `${value.toFixed(2)} m` : '–');

export const degrees = (radians: number) => (Number.isFinite(radians) ? `${((radians * 180) / Math.PI).toFixed(1).replace(/^-0\.0$/, '0.0')}°` : '–');

// With the sign of the direction: counter-clockwise is positive.
export function turned(radians: number): string {
  const text = `${Math.abs((radians * 180) / Math.PI).toFixed(2)}°`;
  return text === '0.00°' ? text : `${radians > 0 ? '+' : '−'}${text}`;
}

// Robots may count their turns: a direction is within half a turn of straight ahead.
const direction = (yaw: number) => Math.atan2(Math.sin(yaw), Math.cos(yaw));

export const pose = ({ x, y, yaw }: { x: number; y: number; yaw: number }) => `${x.toFixed(2)}, ${y.toFixed(2)} m, ${degrees(direction(yaw))}`;

// "4 min", of seconds.
export function age(seconds: number): string {
  if (seconds < 60) return `${Math.floor(seconds)} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min`;
  if (seconds < 86_400) return `${Math.floor(seconds / 3600)} h`;
  return `${Math.floor(seconds / 86_400)} d`;
}

const two = (value: number) => String(value).padStart(2, '0');

export const clock = (ms: number) => {
  const time = new Date(ms);
  return `${two(time.getHours())}:${two(time.getMinutes())}:${two(time.getSeconds())}`;
};

// 2026-11-23 14:02:11, in this computer's time zone.
export const dateTime = (ms: number) => {
  const time = new Date(ms);
  return `${time.getFullYear()}-${two(time.getMonth() + 1)}-${two(time.getDate())} ${clock(ms)}`;
};

// 51 /s; nothing is a dash.
export const perSecond = (rate: number) => (rate > 0 ? `${rate < 9.95 ? rate.toFixed(1) : Math.round(rate)} /s` : '–');

export function bytes(count: number): string {
  if (count < 1000) return `${count} B`;
  if (count < 1e6) return `${(count / 1e3).toFixed(1)} kB`;
  return `${(count / 1e6).toFixed(1)} MB`;
}

export const levelName = (level: number) => (level === 0 ? 'Ground floor' : `Level ${level}`);

// A name with the beginnings of its UUIDs, which tell one thing from another.
export const shortened = (name: string) => name.replace(/\b([0-9a-f]{8})-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}\b/g, '$1');

// 1 map, 2 maps.
export const count = (n: number, one: string, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;

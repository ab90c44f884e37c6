// SPDX-License-Identifier: Apache-2.0
import { fromJsonString } from '@bufbuild/protobuf';
import { siteName } from '../../api/names';
import { upload, type Progress } from '../../api/upload';
import type { PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import type { Point } from '../../scene/camera';
import { ImportPriorMapResponseSchema } from '../../gen/enfilade/v1/prior_map_service_pb';

// What a person has typed.
export interface Import {
  file: File | undefined;
  title: string;
  level: string;
  // Of a PDF; empty: its only one.
  page: string;
  // Of SVG and DXF, with commas between; empty: all.
  layers: string;
  // Two points of a picture, as far as they are shown, and the metres between them; no points: none is given.
  measure: Point[];
  metres: string;
}

const kinds = /\.(png|jpe?g|pdf|svg|dxf|geojson|json|ya?ml|pgm)$/i;

export const hasPages = (file: { name: string } | undefined) => /\.pdf$/i.test(file?.name ?? '');

// Whether the browser shows it, so that a distance can be clicked in it.
export const isShown = (file: { name: string } | undefined) => /\.(png|jpe?g)$/i.test(file?.name ?? '');

export const hasLayers = (file: { name: string } | undefined) => /\.(svg|dxf)$/i.test(file?.name ?? '');

// What is missing or wrong; undefined: nothing that the server would not know better.
export function lacking({ file, title, level, page, measure, metres }: Omit<Import, 'file' | 'layers'> & { file: { name: string } | undefined }): string | undefined {
  if (file === undefined) return 'Choose the file of the plan.';
  if (!kinds.test(file.name)) return 'A plan is a PNG, JPEG, PDF, SVG, DXF or GeoJSON file, or a building.yaml of Open-RMF.';
  if (title.trim() === '') return 'Give the plan a name.';
  if (!/^-?\d+$/.test(level.trim())) return 'The level is a whole number; 0 is the ground floor.';
  if (hasPages(file) && !/^([1-9]\d*)?$/.test(page.trim())) return 'Pages are counted from 1.';
  if (isShown(file) && measure.length === 1) return 'Click the second point of the distance, or take the first one back.';
  if (isShown(file) && measure.length === 2 && !(lengthIn(metres) > 0)) return 'Type how many metres lie between the two points.';
  return undefined;
}

const lengthIn = (text: string) => Number(text.trim().replace(',', '.'));

// The fields that the gateway expects; those that are empty are left out.
export function fieldsOf({ file, title, level, page, layers, measure, metres }: Omit<Import, 'file'> & { file: { name: string } | undefined }): [name: string, value: string][] {
  const fields: [string, string][] = [['display_name', title.trim()], ['level', level.trim()]];
  if (hasPages(file) && page.trim() !== '') fields.push(['page', page.trim()]);
  if (hasLayers(file) && layers.trim() !== '') fields.push(['layers', layers.trim()]);
  const [from, to] = measure;
  if (isShown(file) && from && to) fields.push(['measure', `${from.x},${from.y},${to.x},${to.y}=${lengthIn(metres)}`]);
  return fields;
}

export async function importPlan(site: string, what: Import, onProgress: (progress: Progress) => void, signal: AbortSignal): Promise<PriorMap> {
  const form = new FormData();
  for (const [name, value] of fieldsOf(what)) form.append(name, value);
  form.append('file', what.file!, what.file!.name);
  const answer = await upload(`/v1/${siteName(site)}/priorMaps:import`, form, onProgress, signal);
  return fromJsonString(ImportPriorMapResponseSchema, answer, { ignoreUnknownFields: true }).priorMap!;
}

// SPDX-License-Identifier: Apache-2.0
import { errorOfResponse } from '../../../api/errors';
import { fileOf } from '../plans';

export const textKey = ({ name, etag }: { name: string; etag: string }) => ['planText', name, etag];

// The plan.geojson of a version of the plan.
export async function readPlanText({ name, etag }: { name: string; etag: string }): Promise<string> {
  const response = await fetch(`${fileOf(name, 'plan.geojson', 'plan')}&etag=${encodeURIComponent(etag)}`);
  if (!response.ok) throw await errorOfResponse(response);
  return response.text();
}

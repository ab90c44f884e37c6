// SPDX-License-Identifier: Apache-2.0
import { errorOfResponse } from './errors';

// What GET /statusz tells of the gateway that serves this page, since it began.
export interface GatewayStatus {
  uptimeS: number;
  // Streams included.
  openRequests: number;
  // That have ended; of these, answered with 5xx, and not taken whole by the client.
  requests: number;
  serverErrors: number;
  cutAnswers: number;
  // Of answers' bodies.
  sentBytes: number;
}

export async function gatewayStatus(): Promise<GatewayStatus> {
  const response = await fetch('/statusz');
  if (!response.ok) throw await errorOfResponse(response);
  return (await response.json()) as GatewayStatus;
}

// SPDX-License-Identifier: Apache-2.0
// google.rpc.Status as JSON, and what is an answer that has none.
import { Code, ConnectError } from '@connectrpc/connect';

// For answers that do not come from our gateway, such as those of a proxy.
const codeOfStatus: Record<number, Code> = {
  400: Code.InvalidArgument,
  401: Code.Unauthenticated,
  403: Code.PermissionDenied,
  404: Code.NotFound,
  409: Code.Aborted,
  429: Code.ResourceExhausted,
  501: Code.Unimplemented,
  502: Code.Unavailable,
  503: Code.Unavailable,
  504: Code.DeadlineExceeded,
};

export function errorOfStatus(status: unknown, header?: Headers): ConnectError {
  const { code, message } = (status ?? {}) as { code?: unknown; message?: unknown };
  const known = typeof code === 'number' && code >= 1 && code <= 16 ? (code as Code) : Code.Unknown;
  return new ConnectError(typeof message === 'string' ? message : 'no reason was given', known, header);
}

export async function errorOfResponse(response: Response): Promise<ConnectError> {
  const text = await response.text();
  try {
    const status = JSON.parse(text) as { code?: unknown };
    if (typeof status.code === 'number') return errorOfStatus(status, response.headers);
  } catch {
    // Not JSON: told by the HTTP status below.
  }
  const code = codeOfStatus[response.status] ?? Code.Unknown;
  return new ConnectError(`HTTP ${response.status} ${response.statusText}`.trim(), code, response.headers);
}

export interface Problem {
  title: string;
  // What is wrong with which resource.
  text: string;
  // What to do about it.
  remedy: string;
  requestId?: string;
}

const titles: Partial<Record<Code, [title: string, remedy: string]>> = {
  [Code.NotFound]: ['Not found', 'It may have been deleted or renamed. Go back and choose another one.'],
  [Code.Unavailable]: ['The server does not answer', 'This page tries again by itself. On the server: enfilade server status'],
  [Code.DeadlineExceeded]: ['The server took too long', 'Try again; if it stays slow, look at the Health page.'],
  [Code.ResourceExhausted]: ['Too much at once', 'Wait a moment and try again.'],
  [Code.Aborted]: ['Somebody else changed this', 'Load it again and repeat the change.'],
  [Code.FailedPrecondition]: ['Not possible in this state', 'See what the message asks for.'],
  [Code.InvalidArgument]: ['The request is not valid', 'See what the message asks for.'],
  [Code.PermissionDenied]: ['Not allowed', 'Ask the administrator of this gateway.'],
  [Code.Unimplemented]: ['The server does not know this call', 'Server and dashboard have different versions: update the older one.'],
};

export function problemOf(error: unknown): Problem {
  const failure = ConnectError.from(error);
  const [title, remedy] = titles[failure.code] ?? ['Something went wrong', 'Try again; the log of the server has the request id.'];
  const requestId = failure.metadata.get('x-request-id') ?? undefined;
  return { title, text: failure.rawMessage, remedy, ...(requestId !== undefined && { requestId }) };
}

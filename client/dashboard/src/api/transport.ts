// SPDX-License-Identifier: Apache-2.0
// Typed calls over the REST API that other programs use: int64 as bigint, NaN and Infinity, bytes and oneofs come out of
// the generated code.
import { create, fromJson, toJson, type DescMessage, type DescMethod, type JsonObject, type JsonValue } from '@bufbuild/protobuf';
import { Code, ConnectError, type StreamResponse, type Transport, type UnaryResponse } from '@connectrpc/connect';
import { errorOfResponse, errorOfStatus } from './errors';
import { linesOf } from './lines';
import { callOf, type Binding } from './routes';

export type Fetch = (url: string, init: RequestInit) => Promise<Response>;

const read = { ignoreUnknownFields: true };

async function send(fetcher: Fetch, routes: Record<string, Binding[]>, method: DescMethod, message: JsonObject, accept: string,
                    header: HeadersInit | undefined, signal: AbortSignal | undefined): Promise<Response> {
  const name = `${method.parent.typeName}.${method.name}`;
  const call = callOf(name, routes[name], message);
  const headers = new Headers(header);
  headers.set('Accept', accept);
  if (call.body !== undefined) headers.set('Content-Type', 'application/json');
  let response: Response;
  try {
    response = await fetcher(call.url, { method: call.verb, headers, body: call.body ?? null, signal: signal ?? null });
  } catch (cause) {
    if (signal?.aborted) throw new ConnectError('cancelled', Code.Canceled, undefined, undefined, cause);
    throw new ConnectError('the gateway cannot be reached', Code.Unavailable, undefined, undefined, cause);
  }
  if (!response.ok) throw await errorOfResponse(response);
  return response;
}

function deadline(signal: AbortSignal | undefined, timeoutMs: number | undefined): AbortSignal | undefined {
  if (timeoutMs === undefined) return signal;
  const limit = AbortSignal.timeout(timeoutMs);
  return signal ? AbortSignal.any([signal, limit]) : limit;
}

async function* messagesOf<O extends DescMessage>(output: O, body: ReadableStream<Uint8Array>) {
  for await (const line of linesOf(body)) {
    const part = JSON.parse(line) as { result?: JsonValue; error?: unknown };
    if (part.error !== undefined) throw errorOfStatus(part.error);
    yield fromJson(output, part.result ?? {}, read);
  }
}

export function createRestTransport(routes: Record<string, Binding[]>, fetcher: Fetch = (url, init) => fetch(url, init)): Transport {
  return {
    async unary(method, signal, timeoutMs, header, input): Promise<UnaryResponse<typeof method.input, typeof method.output>> {
      const message = toJson(method.input, create(method.input, input)) as JsonObject;
      const response = await send(fetcher, routes, method, message, 'application/json', header, deadline(signal, timeoutMs));
      const body = fromJson(method.output, (await response.json()) as JsonValue, read);
      return { stream: false, service: method.parent, method, header: response.headers, trailer: new Headers(), message: body };
    },
    async stream(method, signal, timeoutMs, header, input): Promise<StreamResponse<typeof method.input, typeof method.output>> {
      let message: JsonObject | undefined;
      for await (const part of input) message = toJson(method.input, create(method.input, part)) as JsonObject;
      const response = await send(fetcher, routes, method, message ?? {}, 'application/x-ndjson', header, deadline(signal, timeoutMs));
      if (!response.body) throw new ConnectError('the answer has no body', Code.Internal);
      return {
        stream: true, service: method.parent, method, header: response.headers, trailer: new Headers(),
        message: messagesOf(method.output, response.body),
      };
    },
  };
}


// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError } from '@connectrpc/connect';
import { errorOfResponse } from './errors';

export interface Progress {
  // Bytes.
  sent: number;
  size: number;
}

// Posts a form and returns the text of the answer. By XMLHttpRequest: fetch does not tell how much has been sent.
export function upload(url: string, form: FormData, onProgress: (progress: Progress) => void, signal: AbortSignal): Promise<string> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', url);
    request.setRequestHeader('Accept', 'application/json');
    request.upload.onprogress = ({ loaded, total }) => onProgress({ sent: loaded, size: total });
    request.onload = () => {
      if (request.status < 400) return resolve(request.responseText);
      const headers = { 'X-Request-Id': request.getResponseHeader('X-Request-Id') ?? '' };
      errorOfResponse(new Response(request.responseText, { status: request.status, statusText: request.statusText, headers })).then(reject, reject);
    };
    request.onerror = () => reject(new ConnectError('the connection to the gateway broke off', Code.Unavailable));
    request.onabort = () => reject(new ConnectError('cancelled', Code.Canceled));
    signal.addEventListener('abort', () => request.abort());
    request.send(form);
  });
}

// SPDX-License-Identifier: Apache-2.0
import './styles/upload.css';
import { Code, ConnectError } from '@connectrpc/connect';
import { problemOf } from '../api/errors';
import type { Progress } from '../api/upload';
import { bytes } from './format';

// Why nothing has come of an upload.
export function refusalOf(error: unknown): string {
  if (ConnectError.from(error).code === Code.Canceled) return 'Cancelled: nothing was stored.';
  const { title, text } = problemOf(error);
  return `${title}: ${text}`;
}

// How far an upload is.
export function Sending({ progress, cancel }: { progress: Progress | undefined; cancel: () => void }) {
  const isSent = progress !== undefined && progress.sent >= progress.size;
  return (
    <div className="import-progress">
      <progress aria-label="Upload" max={progress?.size ?? 1} value={progress?.sent ?? 0} />
      <span role="status">{progress === undefined ? 'Beginning …' : isSent ? 'The server reads the files …' : `${bytes(progress.sent)} of ${bytes(progress.size)} sent`}</span>
      <button className="button" type="button" onClick={cancel}>
        Cancel
      </button>
    </div>
  );
}

// SPDX-License-Identifier: Apache-2.0
import type { ReactNode } from 'react';

// What came of an upload, and what the server noticed in it.
export function UploadResult({ children, warnings }: { children: ReactNode; warnings: string[] }) {
  return (
    <div role="status">
      <p>Imported: {children}</p>
      {warnings.map((warning) => (
        <p key={warning} className="sub">
          {warning}
        </p>
      ))}
    </div>
  );
}

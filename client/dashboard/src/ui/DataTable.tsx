// SPDX-License-Identifier: Apache-2.0
// A table that is searched, sorted and turned page by page. Where it stands is in the address (q, o, p), so that it can be
// sent to somebody else and survives a reload.
import type { ReactNode } from 'react';
import { setQuery, usePlace } from '../app/router';
import { byName, count } from './format';

export interface Column<T> {
  title: string;
  cell: (row: T) => ReactNode;
  // What it is sorted by; without it it is not.
  order?: (row: T) => number | string;
  number?: boolean;
}

interface Props<T> {
  caption: string;
  // One row, several rows.
  noun: [one: string, many: string];
  rows: T[];
  columns: Column<T>[];
  keyOf: (row: T) => string;
  // What the search looks at.
  textOf: (row: T) => string;
  selected?: string | undefined;
}

const PAGE = 50;

function compare(a: number | string, b: number | string): number {
  if (typeof a === 'number' && typeof b === 'number') return a - b;
  return byName(String(a), String(b));
}

// "2" sorts by the third column, "-2" the other way round.
function sorted<T>(rows: T[], columns: Column<T>[], text: string | null): { rows: T[]; column: number; down: boolean } {
  const column = Math.abs(Number.parseInt(text ?? '', 10));
  const order = columns[column]?.order;
  if (!order) return { rows, column: -1, down: false };
  const down = text!.startsWith('-');
  return { rows: [...rows].sort((a, b) => (down ? -1 : 1) * compare(order(a), order(b))), column, down };
}

export function DataTable<T>({ caption, noun, rows, columns, keyOf, textOf, selected }: Props<T>) {
  const { query } = usePlace();
  const search = query.get('q') ?? '';
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const found = rows.filter((row) => words.every((word) => textOf(row).toLowerCase().includes(word)));
  const { rows: all, column, down } = sorted(found, columns, query.get('o'));
  const pageCount = Math.max(1, Math.ceil(all.length / PAGE));
  const page = Math.min(pageCount, Math.max(1, Number(query.get('p')) || 1));
  const shown = all.slice((page - 1) * PAGE, page * PAGE);
  const turn = (to: number) => setQuery({ p: to > 1 ? String(to) : undefined });
  return (
    <>
      <div className="table-tools">
        <input className="field" type="search" placeholder={`Search ${noun[1]}`} aria-label={`Search ${noun[1]}`} value={search} onChange={(event) => setQuery({ q: event.target.value, p: undefined })} />
        <span className="sub" role="status">
          {words.length > 0 ? `${found.length} of ${count(rows.length, ...noun)}` : count(rows.length, ...noun)}
        </span>
      </div>
      <div className="card table-scroll" tabIndex={0} role="region" aria-label={caption}>
        <table className="table">
          <thead>
            <tr>
              {columns.map(({ title, order, number }, i) => (
                <th key={title} scope="col" className={number ? 'number' : undefined} aria-sort={i !== column ? undefined : down ? 'descending' : 'ascending'}>
                  {order ? (
                    <button onClick={() => setQuery({ o: i === column && !down ? `-${i}` : String(i), p: undefined })}>
                      {title}
                      {i === column && <span aria-hidden="true">{down ? ' ↓' : ' ↑'}</span>}
                    </button>
                  ) : (
                    title
                  )}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {shown.map((row) => (
              <tr key={keyOf(row)} aria-selected={selected === undefined ? undefined : keyOf(row) === selected}>
                {columns.map(({ title, cell, number }) => (
                  <td key={title} className={number ? 'number' : undefined}>
                    {cell(row)}
                  </td>
                ))}
              </tr>
            ))}
            {shown.length === 0 && (
              <tr>
                <td colSpan={columns.length} className="sub">
                  Nothing fits “{search}”. Search for another word, or clear the search.
                </td>
              </tr>
            )}
          </tbody>
        </table>
      </div>
      {pageCount > 1 && (
        <nav className="table-tools" aria-label="Pages of the table">
          <button className="button" disabled={page === 1} onClick={() => turn(page - 1)}>
            Previous
          </button>
          <span className="sub">
            Page {page} of {pageCount}
          </span>
          <button className="button" disabled={page === pageCount} onClick={() => turn(page + 1)}>
            Next
          </button>
        </nav>
      )}
    </>
  );
}

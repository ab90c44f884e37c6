// SPDX-License-Identifier: Apache-2.0
// What a person has done and the server has not acknowledged. It is kept in the browser, so that neither a crash nor days
// without a network lose it.

export type Operation =
  // `edit`: a MapEdit as JSON.
  | { kind: 'append'; id: string; edit: string }
  | { kind: 'setActive'; ids: string[]; active: boolean; author: string };

export interface StoredOperation {
  key: number;
  // The draft's name.
  draft: string;
  // The page that has made it, or has taken it over.
  owner: string;
  operation: Operation;
}

export interface OperationStore {
  // Whether it survives the page.
  readonly isDurable: boolean;
  add(draft: string, owner: string, operation: Operation): Promise<number>;
  remove(keys: readonly number[]): Promise<void>;
  // In the order in which they were added.
  list(draft: string): Promise<StoredOperation[]>;
  give(keys: readonly number[], owner: string): Promise<void>;
}

// For browsers that keep nothing, and for tests.
export class MemoryStore implements OperationStore {
  readonly isDurable = false;
  private readonly all = new Map<number, StoredOperation>();
  private next = 1;

  async add(draft: string, owner: string, operation: Operation) {
    const key = this.next++;
    this.all.set(key, { key, draft, owner, operation });
    return key;
  }

  async remove(keys: readonly number[]) {
    for (const key of keys) this.all.delete(key);
  }

  async list(draft: string) {
    return [...this.all.values()].filter((stored) => stored.draft === draft).map((stored) => ({ ...stored }));
  }

  async give(keys: readonly number[], owner: string) {
    for (const key of keys) {
      const stored = this.all.get(key);
      if (stored) this.all.set(key, { ...stored, owner });
    }
  }
}

const DATABASE = 'enfilade.edits';
const STORE = 'operations';

const answered = <T>(request: IDBRequest<T>) => new Promise<T>((resolve, reject) => {
  request.onsuccess = () => resolve(request.result);
  request.onerror = () => reject(request.error);
});

const done = (transaction: IDBTransaction) => new Promise<void>((resolve, reject) => {
  transaction.oncomplete = () => resolve();
  transaction.onerror = transaction.onabort = () => reject(transaction.error);
});

class DatabaseStore implements OperationStore {
  readonly isDurable = true;

  constructor(private readonly database: IDBDatabase) {}

  async add(draft: string, owner: string, operation: Operation) {
    const transaction = this.begin();
    const key = answered(transaction.objectStore(STORE).add({ draft, owner, operation }));
    await done(transaction);
    return Number(await key);
  }

  async remove(keys: readonly number[]) {
    const transaction = this.begin();
    for (const key of keys) transaction.objectStore(STORE).delete(key);
    await done(transaction);
  }

  async list(draft: string) {
    const index = this.database.transaction(STORE).objectStore(STORE).index('draft');
    return ((await answered(index.getAll(draft))) as StoredOperation[]).sort((a, b) => a.key - b.key);
  }

  async give(keys: readonly number[], owner: string) {
    const transaction = this.begin();
    const store = transaction.objectStore(STORE);
    for (const key of keys) {
      store.get(key).onsuccess = ({ target }) => {
        const stored = (target as IDBRequest<StoredOperation | undefined>).result;
        if (stored) store.put({ ...stored, owner });
      };
    }
    await done(transaction);
  }

  private begin() {
    return this.database.transaction(STORE, 'readwrite', { durability: 'strict' });
  }
}

// Private windows may have none: then edits live as long as the page, which says so.
export async function openStore(): Promise<OperationStore> {
  try {
    const request = indexedDB.open(DATABASE, 1);
    request.onupgradeneeded = () => {
      request.result.createObjectStore(STORE, { keyPath: 'key', autoIncrement: true }).createIndex('draft', 'draft');
    };
    return new DatabaseStore(await answered(request));
  } catch {
    return new MemoryStore();
  }
}

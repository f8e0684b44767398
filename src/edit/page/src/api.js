// What the page asks of the server that it comes from: see src/edit/server/routes.rs.

import { unpack } from '../../../view/page/src/payload.js';

/** An answer that is no answer: `status` is that of HTTP, 0 where no server is. */
export class Refused extends Error {
  constructor(message, status) {
    super(message);
    this.status = status;
  }
}

async function ask(path, body) {
  const options =
    body === undefined
      ? {}
      : { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) };
  let response;
  try {
    response = await fetch(path, { ...options, cache: 'no-store' });
  } catch {
    throw new Refused('gable edit no longer answers: it was ended, or the machine sleeps. What was done is saved.', 0);
  }
  if (!response.ok) {
    const told = await response.json().catch(() => null);
    throw new Refused(told?.error ?? `the server answers ${response.status}`, response.status);
  }
  return response;
}

const json = async (path, body) => (await ask(path, body)).json();
const packed = async (path, body) => unpack(await (await ask(path, body)).text());

export const api = {
  model: () => json('api/model'),
  building: (id) => packed(`api/building?id=${encodeURIComponent(id)}`),
  edit: (id, revision, action) => packed('api/edit', { id, revision, action }),
  undo: (id, revision) => packed('api/undo', { id, revision }),
  redo: (id, revision) => packed('api/redo', { id, revision }),
  clear: (id, revision) => packed('api/clear', { id, revision }),
  state: (id, state) => json('api/state', { id, state }),
  export: () => json('api/export', {}),
};

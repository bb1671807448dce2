'use strict';
// The handles of the library: each is destroyed once, by its owner or when that was forgotten.

const { isMainThread } = require('node:worker_threads');
const { ABI_VERSION, functions } = require('./native.js');
const { check } = require('./errors.js');

// What the open owners of this thread hold.
const open = new Set();

function destroy(held) {
  open.delete(held);
  held.release?.();
  functions[`cylfuse_${held.kind}_destroy`](held.handle);
}

/** How many calls of this thread wait for the pool or run on it. */
const calls = { onPool: 0 };

// Frees the handles that were forgotten, and those that a worker leaves behind; the main thread leaves none. A call that
// still waits for the pool would begin with what is freed here, and nothing tells it: then they are left.
const registry = new FinalizationRegistry(destroy);
if (!isMainThread) process.on('exit', () => { if (calls.onPool === 0) open.forEach(destroy); });

/** Creates a fitter, frame or detector, which is destroyed with its owner; `make` may do so by another function. */
function create(kind, owner, make = functions[`cylfuse_${kind}_create`]) {
  const out = [null];
  check(make(ABI_VERSION, out));
  const held = { kind, handle: out[0] };
  open.add(held);
  registry.register(owner, held, owner);
  return held;
}

/** Destroys what `create` gave to its owner. */
function close(held, owner) {
  registry.unregister(owner);
  destroy(held);
}

module.exports = { calls, create, close };

'use strict';
// Fits and searches on the thread pool of Node.

const fs = require('node:fs');
const { inspect } = require('node:util');
const { isMainThread } = require('node:worker_threads');
const { calls } = require('./handles.js');
const { koffi, Handle, FitEndedCallback, onPool, initialised, structs } = require('./native.js');

// koffi takes 256 calls at a time, and the callbacks of calls count as such. The pool has 4 threads, or as many as
// UV_THREADPOOL_SIZE says.
let places = 64;
const waiting = [];

/** How many calls with callbacks are on the pool. */
let withCallbacks = 0;

/** Memory for a struct that the library fills. */
function allocated(name) {
  const memory = koffi.alloc(structs[name], 1);
  koffi.encode(memory, structs[name], initialised(name));
  return memory;
}

/** Copies a typed array to where the collector does not move it. */
function copied(array) {
  const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  const memory = koffi.alloc('uint8_t', Math.max(bytes.length, 1));
  if (bytes.length > 0) new Uint8Array(koffi.view(memory, bytes.length)).set(bytes);
  return memory;
}

/**
 * Makes a call when there is a place: its status, undefined when it was cancelled while it waited. `callsBack` says
 * whether it has callbacks.
 */
async function run(call, parameters, callsBack, cancelled) {
  if (places > 0) places -= 1;
  else await new Promise((resolve) => { waiting.push(resolve); });
  withCallbacks += callsBack;
  try {
    if (cancelled()) return undefined;
    return await new Promise((resolve, reject) => {
      calls.onPool += 1;
      call(...parameters, (error, value) => {
        calls.onPool -= 1;
        if (error) reject(error);
        else resolve(value);
      });
    });
  } finally {
    withCallbacks -= callsBack;
    // The place goes to the next one, if any waits.
    const next = waiting.shift();
    if (next) next();
    else places += 1;
  }
}

/** Runs a fit: its status, result and estimate. */
async function fitOnPool(handle, callsBack, cancelled) {
  const [result, estimate] = [allocated('result'), allocated('cylinder_estimate')];
  try {
    const status = await run(onPool.fit, [handle, result, estimate], callsBack, cancelled);
    return {
      status, result: koffi.decode(result, structs.result),
      estimate: koffi.decode(estimate, structs.cylinder_estimate),
    };
  } finally {
    koffi.free(result);
    koffi.free(estimate);
  }
}

/**
 * Fits those that the handles are of: the status of all, and that of each. `ended` is called after each fit, and returns
 * whether to stop; null for nothing.
 */
async function fitAllOnPool(handles, threads, ended) {
  const count = handles.length;
  const [list, statuses] = [koffi.alloc(Handle, Math.max(count, 1)), koffi.alloc('int32_t', Math.max(count, 1))];
  const callback = ended && koffi.register((index, status) => ended(Number(index), status), FitEndedCallback);
  try {
    if (count > 0) koffi.encode(list, koffi.array(Handle, count), handles);
    const status = await run(onPool.fitAll, [list, count, threads, callback, null, statuses], Boolean(ended), () => false);
    return { status, statuses: count > 0 ? Array.from(koffi.decode(statuses, koffi.array('int32_t', count))) : [] };
  } finally {
    if (callback) koffi.unregister(callback);
    koffi.free(list);
    koffi.free(statuses);
  }
}

/** Searches a frame: the status. */
const detectOnPool = (handle, frame, callsBack, cancelled) => run(onPool.detect, [handle, frame], callsBack, cancelled);

/** Searches points, of which it makes a copy at once: the status. */
async function detectPointsOnPool(handle, view, callsBack, cancelled) {
  const memory = [koffi.alloc(structs.points_view, 1)];
  try {
    const copy = { ...view };
    for (const name of ['data', 'weights', 'normals']) {
      if (!copy[name]) continue;
      copy[name] = copied(copy[name]);
      memory.push(copy[name]);
    }
    koffi.encode(memory[0], structs.points_view, copy);
    return await run(onPool.detectPoints, [handle, memory[0]], callsBack, cancelled);
  } finally {
    memory.forEach(koffi.free);
  }
}

// A callback on the pool waits for the main thread, and at the end of the process Node waits for the pool: for ever. So
// with such a call the process ends here, after all that listened for its end before.
if (isMainThread) {
  let fatal = null;
  process.on('uncaughtExceptionMonitor', (error) => { fatal = { error }; });
  process.on('exit', (code) => {
    if (withCallbacks === 0) return;
    // Node would print it only after this.
    const printed = fatal && process.listenerCount('uncaughtException') === 0;
    if (printed) fs.writeSync(2, `Uncaught:\n${inspect(fatal.error)}\n`);
    koffi.load(process.platform === 'win32' ? 'ucrtbase.dll' : null).func('void _exit(int)')(code);
  });
}

module.exports = { fitOnPool, fitAllOnPool, detectOnPool, detectPointsOnPool };

'use strict';
// Fits on the thread pool of Node.

const fs = require('node:fs');
const { inspect } = require('node:util');
const { isMainThread } = require('node:worker_threads');
const { koffi, fitAsync, initialised, structs } = require('./native.js');
const { enumerations } = require('./names.js');

// koffi takes 256 calls at a time, and the callbacks of calls count as such. The pool has 4 threads, or as many as
// UV_THREADPOOL_SIZE says.
let places = 64;
const waiting = [];

/** How many fits with callbacks are on the pool. */
let heard = 0;

/** Memory for a struct that the library fills. */
function allocated(name) {
  const memory = koffi.alloc(structs[name], 1);
  koffi.encode(memory, structs[name], initialised(name));
  return memory;
}

/**
 * Runs a fit when there is a place: its status, result and estimate. `hears` says whether it calls back; `cancelled`
 * whether it was cancelled while it waited.
 */
async function fitOnPool(handle, hears, cancelled) {
  if (places > 0) places -= 1;
  else await new Promise((resolve) => { waiting.push(resolve); });
  heard += hears;
  const [result, estimate] = [allocated('result'), allocated('cylinder_estimate')];
  try {
    if (cancelled()) return { status: enumerations.status.CANCELLED };
    const status = await new Promise((resolve, reject) => {
      fitAsync(handle, result, estimate, (error, value) => (error ? reject(error) : resolve(value)));
    });
    return {
      status, result: koffi.decode(result, structs.result),
      estimate: koffi.decode(estimate, structs.cylinder_estimate),
    };
  } finally {
    koffi.free(result);
    koffi.free(estimate);
    heard -= hears;
    // The place goes to the next one, if any waits.
    const next = waiting.shift();
    if (next) next();
    else places += 1;
  }
}

// A callback on the pool waits for the main thread, and at the end of the process Node waits for the pool: for ever. So
// with such a fit the process ends here, when all that listened before has heard of it.
if (isMainThread) {
  let fatal = null;
  process.on('uncaughtExceptionMonitor', (error) => { fatal = { error }; });
  process.on('exit', (code) => {
    if (heard === 0) return;
    // Node would print it only after this.
    const printed = fatal && process.listenerCount('uncaughtException') === 0;
    if (printed) fs.writeSync(2, `Uncaught:\n${inspect(fatal.error)}\n`);
    koffi.load(process.platform === 'win32' ? 'ucrtbase.dll' : null).func('void _exit(int)')(code);
  });
}

module.exports = { fitOnPool };

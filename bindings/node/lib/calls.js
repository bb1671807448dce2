'use strict';
// The calls on a fitter or a detector: one at a time, with what their callbacks throw.

const { koffi, structs, functions, initialised } = require('./native.js');
const { nameOf, kindOf, enumerations } = require('./names.js');
const { check, checkElsewhere, statusError } = require('./errors.js');
const { addListener, removeListener } = require('./callbacks.js');
const handles = require('./handles.js');

const { status: STATUS } = enumerations;

/** What a callback returned. A promise is refused: the call goes on without waiting for what it would say. */
function answered(what, answer) {
  if (typeof answer?.then !== 'function') return answer;
  // Nobody would handle its failure.
  Promise.resolve(answer).catch(() => {});
  throw new TypeError(`${what} returned a promise; it must be a function that is not async`);
}

/** The callbacks of an owner: apart from it, because the native side must not see its methods. */
class Listener {
  progress = null;
  log = null;
  // What a callback threw, boxed because anything can be thrown; the call goes on throwing it.
  thrown = null;

  /** @param convert makes a value of the struct of progress */
  constructor(convert) {
    this.convert = convert;
  }

  get callsBack() {
    return Boolean(this.progress || this.log);
  }

  onProgress(progress) {
    if (this.thrown || !this.progress) return this.thrown ? 1 : 0;
    try {
      return answered('progress', this.progress(this.convert(progress))) === false ? 1 : 0;
    } catch (error) {
      this.thrown = { error };
      return 1;
    }
  }

  onLog(level, message) {
    if (this.thrown || !this.log) return;
    try {
      answered('log', this.log(nameOf('logLevel', level), message));
    } catch (error) {
      this.thrown = { error };
    }
  }
}

/** Owns a handle; a fitter or detector owns one of these. A call that runs keeps it, and with it the handle. */
class Calls {
  #held;
  #running = false;
  // Asks a call on the pool to stop until it has.
  #cancelling = null;

  /** @param create what makes the handle in place of the create function of this kind */
  constructor(kind, progressFromC, create) {
    this.kind = kind;
    this.listener = new Listener(progressFromC);
    this.key = addListener(this.listener);
    const { key } = this;
    try {
      this.#held = handles.create(kind, this, create);
    } catch (error) {
      removeListener(key);
      throw error;
    }
    this.#held.release = () => removeListener(key);
  }

  close() {
    if (this.#running) throw statusError(STATUS.BUSY);
    if (this.#held === null) return;
    handles.close(this.#held, this);
    this.#held = null;
  }

  cancel() {
    const handle = this.#open();
    const cancel = () => functions[`cylfuse_${this.kind}_cancel`](handle);
    // A call on the pool may not have begun, and only one that has can be cancelled.
    if (this.#running) this.#cancelling ??= setInterval(cancel, 1);
    const status = cancel();
    if (status !== STATUS.OK) throw statusError(status);
  }

  /** Makes a call. */
  run(call) {
    const handle = this.#start();
    try {
      const status = call(handle);
      this.#throw();
      check(status);
    } finally {
      this.#end();
    }
  }

  /** Makes a call on the pool, by a function of pool.js, and then reads what it gave. */
  async runOnPool(call, read) {
    const handle = this.#start();
    try {
      const { status, ...out } = await call(handle, this.listener.callsBack, () => this.#cancelling !== null);
      this.#throw();
      if (status === undefined) throw statusError(STATUS.CANCELLED);
      checkElsewhere(status, this.#held);
      return read(handle, out);
    } finally {
      this.#end();
    }
  }

  /** Makes one call on the handles of several, none of which takes another one meanwhile; null for one that is busy. */
  static async onAll(all, call) {
    const started = [];
    try {
      const handles = all.map((calls) => {
        const handle = calls.#open();
        if (calls.#running) return null;
        calls.#running = true;
        started.push(calls);
        return handle;
      });
      return await call(handles);
    } finally {
      started.forEach((calls) => calls.#end());
    }
  }

  /** Why a call that ran elsewhere failed. */
  failure(status) {
    // Then it is in another call, or was not called: its text is not about this.
    if (status === STATUS.BUSY) return statusError(status);
    try {
      checkElsewhere(status, this.#held);
    } catch (error) {
      return error;
    }
    return null;
  }

  /** Calls what fills a struct. */
  filled(name, call) {
    const struct = initialised(name);
    this.run((handle) => call(handle, struct));
    return struct;
  }

  /** Lists structs. */
  structs(name, capacity, list) {
    const size = koffi.sizeof(structs[name]);
    const make = (length) => Buffer.alloc(length * size);
    const call = (handle, out, length, count) => list(handle, out, size, length, count);
    const { items, count } = this.list(capacity, make, call);
    return Array.from({ length: count }, (_, index) => koffi.decode(items, index * size, structs[name]));
  }

  /** Lists into what is made for a number of items. A `capacity` that is large enough saves asking for that number. */
  list(capacity, make, list) {
    const count = [0];
    let items = make(capacity);
    this.run((handle) => {
      const status = list(handle, items, capacity, count);
      if (status !== STATUS.BUFFER_TOO_SMALL) return status;
      items = make(Number(count[0]));
      return list(handle, items, count[0], count);
    });
    return { items, count: Number(count[0]) };
  }

  #open() {
    if (this.#held === null) throw new Error(`the ${this.kind} is closed: make a new one`);
    return this.#held.handle;
  }

  /**
   * Begins the one call that may run. The library would answer BUSY by itself, but not before a call on the pool has
   * begun.
   */
  #start() {
    const handle = this.#open();
    if (this.#running) throw statusError(STATUS.BUSY);
    this.#running = true;
    return handle;
  }

  #end() {
    this.#running = false;
    clearInterval(this.#cancelling);
    this.#cancelling = null;
  }

  /** Throws what a callback threw during the call. */
  #throw() {
    const { thrown } = this.listener;
    this.listener.thrown = null;
    if (thrown) throw thrown.error;
  }
}

function checkCallback(what, callback) {
  if (callback === null || typeof callback === 'function') return;
  throw new TypeError(`${what} must be a function or null, not ${kindOf(callback)}`);
}

module.exports = { Calls, answered, checkCallback };

'use strict';

const { functions, initialised } = require('./native.js');
const { nameOf } = require('./names.js');

class CylfuseError extends Error {
  constructor(status, message) {
    super(message);
    this.name = 'CylfuseError';
    this.code = nameOf('status', status);
    this.status = status;
  }
}

/** The error of a status without a message. */
const statusError = (status) => new CylfuseError(status, functions.cylfuse_status_string(status));

/** Throws for a call of this thread that failed, whatever it was on. */
function check(status) {
  if (status !== 0) throw new CylfuseError(status, functions.cylfuse_fitter_last_error(null));
}

/**
 * Throws for a call on a handle that failed on another thread. Its text is with the handle, and is read by a thread
 * whose own last call was on something else.
 */
function checkElsewhere(status, { kind, handle }) {
  if (status === 0) return;
  initialised('counts');
  throw new CylfuseError(status, functions[`cylfuse_${kind}_last_error`](handle));
}

module.exports = { CylfuseError, check, checkElsewhere, statusError };

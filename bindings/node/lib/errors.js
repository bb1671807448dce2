'use strict';

const { functions } = require('./native.js');
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

/** Throws for a failed call on a fitter, or without one (null). */
function check(status, handle = null) {
  if (status !== 0) throw new CylfuseError(status, functions.cylfuse_fitter_last_error(handle));
}

module.exports = { CylfuseError, check, statusError };

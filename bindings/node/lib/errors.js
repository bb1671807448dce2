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

/** The error of a function without a fitter, which has no message of its own. */
const statusError = (status) => new CylfuseError(status, functions.cylfuse_status_string(status));

module.exports = { CylfuseError, statusError };

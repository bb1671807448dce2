'use strict';

const assert = require('node:assert/strict');
const { execFileSync } = require('node:child_process');
const fs = require('node:fs');
const path = require('node:path');
const { test } = require('node:test');

// A folder where the published package is installed; test.sh makes it.
const folder = process.env.CYLFUSE_NODE_PROGRAM;

test('the programs of the README run with the published package', { skip: !folder && 'test.sh installs it' }, () => {
  const programs = fs.readFileSync(path.join(__dirname, '..', 'README.md'), 'utf8').split('```js\n').slice(1)
    .map((rest) => rest.split('```')[0]);
  assert.equal(programs.length, 2);
  const before = programs[0].slice(0, programs[0].indexOf('fitPoints(')).split('\n').length;
  assert.ok(before <= 10, `the fit is in line ${before}`);
  const environment = { ...process.env };
  // The package must find the library inside it.
  delete environment.CYLFUSE_LIBRARY;
  const outputs = programs.map((program, i) => {
    const file = path.join(folder, `program${i}.mjs`);
    fs.writeFileSync(file, program);
    return execFileSync(process.execPath, [file], { env: environment, encoding: 'utf8' });
  });
  assert.match(outputs[0], /^radius 0\.500000\n$/);
  assert.match(outputs[1], /^radius 0\.0400, length 0\.1/);
});

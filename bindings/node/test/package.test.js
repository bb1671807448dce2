'use strict';
// The programs of users, with the package as it is published.

const assert = require('node:assert/strict');
const { execFileSync } = require('node:child_process');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');
const { after, before, test } = require('node:test');

// The folder of the published package; test.sh lays it out.
const published = process.env.CYLFUSE_NODE_PACKAGE;
const skip = !published && 'CYLFUSE_NODE_PACKAGE is not set: test.sh lays that folder out';

const readme = fs.readFileSync(path.join(__dirname, '..', 'README.md'), 'utf8');
const blocks = (language) => readme.split(`\`\`\`${language}\n`).slice(1).map((rest) => rest.split('```')[0]);

// A path with a blank and more letters than ASCII has.
const beside = fs.mkdtempSync(path.join(os.tmpdir(), 'Maße einer Röhre-'));
const folder = path.join(beside, 'pipe');
const environment = { ...process.env, npm_config_loglevel: 'error', npm_config_audit: 'false' };
// The package must find the library inside it.
delete environment.CYLFUSE_LIBRARY;
const run = (command, ...parameters) => execFileSync(command, parameters, { cwd: folder, env: environment, encoding: 'utf8' });

before(() => {
  fs.mkdirSync(folder);
  if (published) fs.symlinkSync(published, path.join(beside, 'cylfuse-node'));
});
after(() => fs.rmSync(beside, { recursive: true }));

test('the programs and commands of the README', { skip }, () => {
  const [smallest, withCamera, scene] = blocks('js');
  const line = smallest.slice(0, smallest.indexOf('fitPoints(')).split('\n').length;
  assert.ok(line <= 10, `the fit is in line ${line}`);
  fs.writeFileSync(path.join(folder, 'pipe.mjs'), smallest);
  assert.match(run('bash', '-e', '-c', blocks('sh')[0]), /\nradius 0\.500000\n$/);
  fs.writeFileSync(path.join(folder, 'camera.mjs'), withCamera);
  assert.equal(run(process.execPath, 'camera.mjs'), 'radius 0.0400, length 0.100, warnings: \n');
  fs.writeFileSync(path.join(folder, 'scene.mjs'), scene);
  assert.equal(run(process.execPath, 'scene.mjs'), 'true true 0.10\n');
  fs.writeFileSync(path.join(folder, 'required.cjs'), "console.log(require('cylfuse').version);");
  assert.match(run(process.execPath, 'required.cjs'), /^\d+\.\d+\.\d+\n$/);
});

test('the types of the package', { skip }, () => {
  for (const name of ['types.mts', 'types.cts']) fs.copyFileSync(path.join(__dirname, name), path.join(folder, name));
  // Without types of Node, which a program need not have.
  for (const options of [{}, { lib: ['esnext', 'dom'], exactOptionalPropertyTypes: true, noUncheckedIndexedAccess: true }]) {
    fs.writeFileSync(path.join(folder, 'tsconfig.json'), JSON.stringify({
      compilerOptions: { strict: true, noEmit: true, target: 'es2022', module: 'nodenext', types: [], ...options },
      files: ['types.mts', 'types.cts'],
    }));
    try {
      run(process.execPath, path.join(__dirname, '..', 'node_modules', 'typescript', 'bin', 'tsc'));
    } catch (error) {
      assert.fail(error.stdout);
    }
  }
});

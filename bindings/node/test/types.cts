// Compiled by the tests, never run: a program with require.
import cylfuse = require('cylfuse');

const fitter = new cylfuse.Fitter();
const axis = [0, 1, 0] as const;
fitter.setOptions({ axis, axisMaxAngle: 0.1, seed: 3n });
const options: cylfuse.Options = fitter.getOptions();
fitter.setOptions(options);
fitter[Symbol.dispose]();

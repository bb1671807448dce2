'use strict';

const { functions } = require('./native.js');
const convert = require('./convert.js');
const { kindOf } = require('./names.js');
const { check } = require('./errors.js');
const handles = require('./handles.js');

class Frame {
  #held = handles.create('frame', this);
  #size = [0, 0];

  close() {
    if (this.#held === null) return;
    handles.close(this.#held, this);
    this.#held = null;
  }

  setIntrinsics(intrinsics) {
    const c = convert.intrinsicsToC(intrinsics);
    check(functions.cylfuse_frame_set_intrinsics(this.#open(), c));
    this.#size = [c.width, c.height];
  }

  setPose(pose) {
    const [rotation, translation] = convert.poseToC('pose', pose);
    check(functions.cylfuse_frame_set_pose(this.#open(), rotation, translation));
  }

  setDepthCamera(camera) {
    const [intrinsics, rotation, translation] = convert.depthCameraToC(camera);
    check(functions.cylfuse_frame_set_depth_camera(this.#open(), intrinsics, rotation, translation));
  }

  setDepth(depth) {
    const view = convert.depthToC(depth);
    check(functions.cylfuse_frame_set_depth(this.#open(), view));
  }

  setImage(image) {
    const view = convert.imageToC(image);
    check(functions.cylfuse_frame_set_image(this.#open(), view));
  }

  #open() {
    if (this.#held === null) throw new Error('the frame is closed: make a new one');
    return this.#held.handle;
  }

  /** The handle of a frame, and the size of its camera. */
  static inside(frame) {
    if (typeof frame !== 'object' || frame === null || !(#held in frame)) {
      throw new TypeError(`frame must be a Frame, not ${kindOf(frame)}`);
    }
    return { handle: frame.#open(), size: frame.#size };
  }
}

// For this package only.
const { inside } = Frame;
delete Frame.inside;

if (Symbol.dispose) Frame.prototype[Symbol.dispose] = Frame.prototype.close;

module.exports = { Frame, inside };

'use strict';

const { functions } = require('./native.js');
const convert = require('./convert.js');
const { kindOf, enumerations } = require('./names.js');
const { check, statusError } = require('./errors.js');
const handles = require('./handles.js');

const { status: STATUS } = enumerations;

class Frame {
  #held = handles.create('frame', this);
  #size = [0, 0];
  // Searches on the pool that use it: the library may not have begun to read it.
  #users = 0;

  close() {
    if (this.#users > 0) throw statusError(STATUS.BUSY);
    if (this.#held === null) return;
    handles.close(this.#held, this);
    this.#held = null;
  }

  setIntrinsics(intrinsics) {
    const c = convert.intrinsicsToC(intrinsics);
    check(functions.cylfuse_frame_set_intrinsics(this.#idle(), c));
    this.#size = [c.width, c.height];
  }

  setPose(pose) {
    const [rotation, translation] = convert.poseToC('pose', pose);
    check(functions.cylfuse_frame_set_pose(this.#idle(), rotation, translation));
  }

  setDepthCamera(camera) {
    const [intrinsics, rotation, translation] = convert.depthCameraToC(camera);
    check(functions.cylfuse_frame_set_depth_camera(this.#idle(), intrinsics, rotation, translation));
  }

  setDepth(depth) {
    const view = convert.depthToC(depth);
    check(functions.cylfuse_frame_set_depth(this.#idle(), view));
  }

  setImage(image) {
    const view = convert.imageToC(image);
    check(functions.cylfuse_frame_set_image(this.#idle(), view));
  }

  #open() {
    if (this.#held === null) throw new Error('the frame is closed: make a new one');
    return this.#held.handle;
  }

  /** The handle, to change the frame. */
  #idle() {
    const handle = this.#open();
    if (this.#users > 0) throw statusError(STATUS.BUSY);
    return handle;
  }

  /** The handle of a frame, and the size of its camera. */
  static inside(frame) {
    if (typeof frame !== 'object' || frame === null || !(#held in frame)) {
      throw new TypeError(`frame must be a Frame, not ${kindOf(frame)}`);
    }
    return { handle: frame.#open(), size: frame.#size };
  }

  /** Keeps a frame as it is until `use` has ended. */
  static async during(frame, use) {
    frame.#users += 1;
    try {
      return await use();
    } finally {
      frame.#users -= 1;
    }
  }
}

// For this package only.
const { inside, during } = Frame;
delete Frame.inside;
delete Frame.during;

if (Symbol.dispose) Frame.prototype[Symbol.dispose] = Frame.prototype.close;

module.exports = { Frame, inside, during };

// All cylinders of a scene.

import type { Numbers, Options, Points, Scalars } from './data.js';
import type { CylfuseError, Fitter, Frame } from './index.js';
import type { Extent, Result } from './results.js';

/** The settings of a detector. The limits of radius and axis hold for the search and for the fits. */
export interface DetectorOptions {
  /** Whether the image of a frame is looked at. Default auto: where there is one. */
  imageUse?: 'auto' | 'ignore';
  /** Most threads, on which cylinders are fitted side by side; the result has the same bits for any number. Default 1. */
  maxThreads?: number;
  /** Most cylinders, those with the highest scores. Default 0 = no limit. */
  maxCount?: number;
  /** Fewest pixels of a cylinder; points for a cloud. Default 100. */
  minPixels?: number | bigint;
  /** The least score, in [0, 1]: the probability that there is a cylinder. Default 0.5. */
  minScore?: number;
  /** The smallest radius. Default 0 = no limit. */
  radiusMin?: number;
  /** The largest radius, equal to radiusMin for a known one. Default 0 = no limit. */
  radiusMax?: number;
  /** The middle of the cone of directions of the axes, in the reference frame. Default [0, 0, 0] = all directions. */
  axis?: Numbers;
  /** The largest angle of an axis from `axis`, from 0 to pi/2; 0 for a known direction. */
  axisMaxAngle?: number;
}

/** A cylinder of a scene. */
export interface Detection {
  /** The probability that there is a cylinder. */
  score: number;
  /** Pixels of its region; points for a cloud. */
  pixels: number;
  /** The outcome of its fit, with the cylinder in the reference frame. */
  result: Result;
  /** Its visible piece; that of a cylinder of a cloud ends with its points; null where there is none. */
  extent: Extent | null;
  /** Why there is no extent; null where there is one. */
  extentError: CylfuseError | null;
}

/**
 * How far a detector is: before the search, after it, and after each fit. A cloud that is searched from many places begins
 * again with each.
 */
export interface DetectionProgress {
  /** It is about to look for cylinders, or fits those that were found. */
  phase: 'search' | 'fit';
  /** Cylinders that are fitted. */
  fitsDone: number;
  /** Cylinders to fit; 0 before the search. */
  fits: number;
}

/** An image of the numbers of cylinders. */
export interface Labels {
  /** Row by row: 1 for the first detection, and so on; 0 = none. */
  data: Uint16Array;
  /** Columns of the colour image or of the cloud. */
  width: number;
  /** Rows; 1 for a cloud that is not organised. */
  height: number;
}

/**
 * Finds all cylinders of a frame or a cloud, without masks, and fits each by the full method.
 *
 * A search gives the cylinders by falling score; there may be none. `detections`, `labels`, `indices` and `fitter` are of
 * the last search that succeeded. The rules of {@link Fitter} hold: one call at a time, and BUSY meanwhile, also for
 * what would change or close a frame in which an asynchronous search is running.
 */
export class Detector {
  constructor();
  /** Frees the detector; a second time does nothing. A forgotten one is freed by the garbage collector. */
  close(): void;
  /** The same, for `using detector = new Detector()`. */
  [Symbol.dispose](): void;
  /** Asks the running search to stop, which then throws CANCELLED. When none is running it does nothing. */
  cancel(): void;
  /** Replaces the options: what is not given takes its default. */
  setOptions(options: DetectorOptions): void;
  /** The options as they are. */
  getOptions(): Required<DetectorOptions>;
  /** Replaces the options of the fits; limits, maxThreads and start must have their defaults: the detector sets them. */
  setFitOptions(options: Options): void;
  /** The options of the fits. */
  getFitOptions(): Required<Options>;
  /**
   * Sets what is called with the progress of a search: before it, after it, and after each fit; false stops the search.
   * What it throws, the search throws, and a TypeError where it returns a promise. A `detect` waits for the event loop to get to it.
   */
  setProgress(callback: ((progress: DetectionProgress) => boolean | void) | null): void;
  /**
   * Finds all cylinders in the depth image of a frame, and fits each to its region by depth and image, on a thread of the
   * pool of Node.
   */
  detect(frame: Frame): Promise<Detection[]>;
  /** The same on this thread. */
  detectSync(frame: Frame): Detection[];
  /**
   * Finds all cylinders in a cloud, organised or not, and fits each to its points, on a thread of the pool of Node. The
   * points are copied at once. It is looked at from where one sensor has seen it, in its origin or where the densities of the
   * points tell; other clouds are looked at from all sides, which takes about ten times as long.
   */
  detectPoints(points: Scalars | Points): Promise<Detection[]>;
  /** The same on this thread, without a copy. */
  detectPointsSync(points: Scalars | Points): Detection[];
  /** The cylinders. */
  detections(): Detection[];
  /**
   * Whether the scene was looked at as a whole. The work of a search with its fits is bounded: of a scene with more in it
   * than that, cylinders may be missing.
   */
  isComplete(): boolean;
  /**
   * The columns (to the right) and rows (down) by which the depth of the frame was moved to where the image shows the same
   * bodies; zeros where it was not. Each result then has the warning `depth-shifted`; labels and indices are those of the
   * depth as it was given.
   */
  depthMoved(): [columns: number, rows: number];
  /** For each pixel of the colour image, or each point of the cloud, the number of its cylinder from 1 on. */
  labels(): Labels;
  /** The pixels or points of one detection (from 0), counted from 0 row by row, rising. */
  indices(index: number): Uint32Array;
  /**
   * A new fitter of one detection (from 0) as its fit left it, with options, frame or points, region as mask, start model
   * and result: for residuals, completion, limbs and so on, or for another fit. It does not depend on the detector.
   */
  fitter(index: number): Fitter;
}

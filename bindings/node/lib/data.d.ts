// What goes into a fit.

/** x, y, z. */
export type Vector = [number, number, number];

/** Numbers in an array of any kind. */
export type Numbers = readonly number[] | Float32Array | Float64Array;

/** An infinite cylinder. */
export interface Cylinder {
  /** A point on the axis. */
  point: Vector;
  /** The direction of the axis: as input of any length but 0, as output of length 1. Its sign has no meaning. */
  direction: Vector;
  /** The radius, greater than 0. */
  radius: number;
}

/**
 * How a cylinder is estimated: points and edges together by an objective, points alone by plain least squares, random
 * sample consensus over the points, or Eberly's algebraic fit by their moments.
 */
export type Method = 'fused' | 'points' | 'ransac' | 'eberly';

/**
 * Where an iteration starts: the best of what follows, two limb segments scaled by the points, Eberly's fit, random
 * sample consensus, the model of {@link Fitter.setStartModel}, or the cylinder of the last successful fit of the fitter,
 * for frames of a sequence, also after {@link Fitter.clear}. From that one, where its limbs are about where it or the points
 * have them, and look in the image as they did, they are not searched, and the result depends on the fits before; where not,
 * and before the first fit, it is as 'auto', with that cylinder or the start model one of the candidates. Of
 * points alone that hold several bodies the one near that cylinder is fitted.
 */
export type Start = 'auto' | 'limbs' | 'moments' | 'ransac' | 'model' | 'last';

/** The settings of a fit. */
export interface Options {
  /** How the cylinder is estimated. Default fused: points and edges together, by the objective. */
  method?: Method;
  /** What fused minimises: default robust; paper is that of Zhang, Liu and Wang, with exactly two segments. */
  objective?: 'robust' | 'paper';
  /** Where the iteration starts. Default auto. */
  start?: Start;
  /** Whether the points must lie on the wall that a camera at the origin sees. Default auto: on with intrinsics. */
  nearWall?: 'auto' | 'on' | 'off';
  /** The coordinates of the iteration. Default auto. */
  chart?: 'auto' | 'local' | 'orthonormal';
  /** What edge segments are for robust: default refine, a start for limbs located in the image; or the measurement. */
  edgeUse?: 'refine' | 'as-given';
  /**
   * How the ends of the visible cylinder are found in a mask. extremes: the rule of the paper, the extreme positions along the
   * axis of the points completed over the mask. located: from all lines along the surface together, in the mask and, when
   * there is one, in the image. Default auto: located for the method `fused` with the objective `robust`, extremes otherwise.
   */
  extentRule?: 'auto' | 'extremes' | 'located';
  /** Most threads; the result has the same bits for any number. Default 1: no thread is started. */
  maxThreads?: number;
  /** Maximum number of iterations, at least 1. Default 400. */
  maxIterations?: number;
  /** Smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12. */
  costTolerance?: number;
  /**
   * Ends where the cosine of the angle between the residuals and what a step can change is not above it. Default 2^-52.
   */
  gradientTolerance?: number;
  /**
   * Ends with a step that moves the surface at the data by not more than this part of their largest coordinate and of their
   * size, in [0, 1). Default 2^-52.
   */
  stepTolerance?: number;
  /** Damping of the first step, greater than 0. Default 1e-3. */
  initialLambda?: number;
  /** Factor by which the damping changes, greater than 1. Default 10. */
  lambdaFactor?: number;
  /** Damping at which no smaller step is tried any more. Default 1e12. */
  maxLambda?: number;
  /** The weight of the edges in paper, in [0, 1]. Default 0.6. */
  edgeWeight?: number;
  /** Seed of the random samples, in [0, 2^64). Default 0. */
  seed?: number | bigint;
  /** Most random samples, 1 to 1,000,000. Default 1000. */
  ransacMaxIterations?: number | bigint;
  /** Distance within which RANSAC counts a point as an inlier. Default 0 = from the data. */
  ransacThreshold?: number;
  /** How many points with independent noise the points of one view are worth. Default 0 = from the data. */
  independentPoints?: number;
  /** Standard deviation of a point across the surface. Default 0 = from the data. */
  depthNoise?: number;
  /** Standard deviation of the values of the image, where these are linear in light. Default 0 = from the image. */
  imageNoise?: number;
  /** Standard deviation of an endpoint of a given segment across its limb, in drawn pixels. Default 0 = 0.5. */
  edgeNoise?: number;
  /** Standard deviation of a side of the mask as a whole across its limb, in drawn pixels. Default 0 = 1.6. */
  maskNoise?: number;
  /** Blur of the image, the standard deviation of a Gaussian in pixels. Default 0 = from the image. */
  imageBlur?: number;
  /**
   * Size of a pixel of the drawing in which edges and masks were made, in pixels of the image. Default 0 = 1 up to
   * 640 x 480 pixels, beyond that the square root of how many times as many pixels the image has.
   */
  drawnPixel?: number;
  /**
   * Standard deviation of the errors that all points of a view share, as a part of their distance. Default 0 = 0.002; less
   * than 0 = none.
   */
  depthShared?: number;
  /** The smallest radius of the returned cylinder. Default 0 = no limit. */
  radiusMin?: number;
  /** The largest radius, equal to radiusMin for a known one. Default 0 = no limit. */
  radiusMax?: number;
  /** The middle of the cone of directions that the returned axis keeps. Default [0, 0, 0] = all directions. */
  axis?: Numbers;
  /** The largest angle of the axis from `axis`, from 0 to pi/2; 0 for a known direction. */
  axisMaxAngle?: number;
}

/** A camera as a calibration gives it. */
export interface Intrinsics {
  /** Width of the image in pixels. */
  width: number;
  /** Height of the image in pixels. */
  height: number;
  /** Focal length in pixel widths, greater than 0. */
  fx: number;
  /** Focal length in pixel heights, greater than 0. */
  fy: number;
  /** Principal point from the centre of the first pixel, to the right. */
  cx: number;
  /** Principal point from the centre of the first pixel, down. */
  cy: number;
  /** What the coefficients mean. Default none. */
  distortionModel?: 'none' | 'brown-conrady' | 'kannala-brandt';
  /** At most 8 coefficients in the order of OpenCV. Default none. */
  distortion?: Numbers;
}

/** Leads from one frame to another: x' = rotation x + translation. */
export interface Pose {
  /** A rotation matrix, row by row. */
  rotation: Numbers;
  /** In the unit of length. */
  translation: Numbers;
}

/** The camera of depth images that are not registered to the colour image. */
export interface DepthCamera {
  /** Those of the depth camera. */
  intrinsics: Intrinsics;
  /** Leads from the frame of the depth camera to that of the colour camera. */
  toColour: Pose;
}

/** Coordinates. */
export type Scalars = Float32Array | Float64Array;

/** A cloud. */
export interface Points<T extends Scalars = Scalars> {
  /** x, y, z of the first point at the beginning. */
  data: T;
  /** Columns of an organised cloud, or the number of points; without width and height all that data hold. */
  width?: number;
  /** Rows of an organised cloud. Default 1. */
  height?: number;
  /** From a point to the next one in its row. Default 3. */
  pointStride?: number;
  /** From a row to the next one. Default width * pointStride. */
  rowStride?: number;
  /** A weight for each point, 0 or greater; 0 drops the point. */
  weights?: T | null;
  /** From a weight to the next one in its row. Default 1. */
  weightStride?: number;
  /** From a row of weights to the next one. Default width * weightStride. */
  weightRowStride?: number;
  /** A normal for each point, of any length and sign. Only RANSAC uses them. */
  normals?: T | null;
  /** From a normal to the next one in its row. Default 3. */
  normalStride?: number;
  /** From a row of normals to the next one. Default width * normalStride. */
  normalRowStride?: number;
}

/** Pixels in memory. Those of depth have the size of the depth camera, where there is one. */
export interface Pixels<T> {
  /** The first row at the beginning. */
  data: T;
  /** Columns; those of the intrinsics. */
  width: number;
  /** Rows; those of the intrinsics. */
  height: number;
  /** From a row to the next one. Default width * pixelStride. */
  rowStride?: number;
  /** From a pixel to the next one in its row. Default 1. */
  pixelStride?: number;
}

/** A depth image of the camera: z, not the distance along the ray; 0, and 65535 of integers, = no measurement. */
export interface Depth<T = Uint16Array | Float32Array> extends Pixels<T> {
  /**
   * Length of one unit of the stored value: 0.001 for millimetres where lengths are to be metres. A Uint16Array needs it; of a
   * Float32Array it is 1 by default.
   */
  scale?: number;
  /**
   * The nearest depth that becomes a point. Default 0. Both limits are those of the points, and of the search of a detector:
   * the extent is found with all depths.
   */
  minDepth?: number;
  /** The farthest depth that becomes a point. Default 0 = no limit. */
  maxDepth?: number;
}

/** Light is the value of a pixel to this power, from 0.1 to 10. */
export interface Light {
  /** Default 1: values linear in light; 2.2 is about sRGB. */
  gamma?: number;
}

/** A grey image of the camera. */
export interface GreyImage extends Pixels<Uint8Array | Uint8ClampedArray | Uint16Array | Float32Array>, Light {
  /** Default grey. */
  format?: 'grey';
}

/** An image of the camera in colour. The default pixelStride is 3, or 4 with alpha. */
export interface ColourImage extends Pixels<Uint8Array | Uint8ClampedArray>, Light {
  /** The order of the bytes of a pixel; alpha is ignored. */
  format: 'rgb' | 'bgr' | 'rgba' | 'bgra';
}

/** An image of the camera. */
export type Image = GreyImage | ColourImage;

/**
 * Which pixels of the colour image show the cylinder: its lateral surface alone, or the whole object with caps, lids and
 * handles. With the objective `robust` a fit leaves out what the depth image shows to be no part of the lateral surface. The
 * boundary may be some pixels off: it is a hint and never measured.
 */
export interface Mask extends Pixels<Uint8Array | Uint8ClampedArray> {
  /** That of the cylinder in an image of labels, 1 to 255. Default 0 = all pixels that are not 0. */
  label?: number;
}

/** Data of a view: all points, the depth image and its mask, the segments, the image. */
export type Input = 'points' | 'depth' | 'edges' | 'image';

/** Pieces of the two lines that bound the cylinder in the (distorted) image, in pixels. */
export interface Segments {
  /** x1, y1, x2, y2 of segment after segment. */
  data: Scalars;
  /** From a segment to the next one. Default 4. */
  stride?: number;
  /** A weight for each segment, from 0 to 1e9; 0 leaves it out. */
  weights?: Float64Array | null;
}

/** A model and where it is looked at. */
export interface Region {
  /** Default: that of the last fit. */
  model?: Cylinder | null;
  /** In the selected view. Default: the one that was pushed. */
  mask?: Mask | null;
}

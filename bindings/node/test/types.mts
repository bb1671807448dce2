// Compiled by the tests, never run: what the types allow and what they refuse.
import {
  Detector, Fitter, Frame, describeEndState, describeFlags, describeTermination, distances, fitAll, fitPoints, projectPoints,
  unprojectPixels, CylfuseError, type Result, type Extent, type Pose,
} from 'cylfuse';

async function use(xyz: Float32Array, depth: Uint16Array, mask: Uint8Array): Promise<number> {
  const fitter = new Fitter();
  fitter.setOptions({ objective: 'paper', axis: [0, 1, 0] });
  fitter.setIntrinsics({ width: 4, height: 2, fx: 1, fy: 1, cx: 0, cy: 0, distortion: new Float64Array(5) });
  fitter.pushDepth({ data: depth, width: 4, height: 2, scale: 0.001 }, { data: mask, width: 4, height: 2 });
  fitter.pushPoints({ data: xyz, pointStride: 4 });
  fitter.setProgress((progress) => progress.iteration < 100);
  const result: Result = await fitter.fit();
  const extent: Extent = fitter.extent({ model: result.cylinder });
  const pose: Pose = { rotation: new Float64Array(9), translation: [0, 0, 0] };
  const intrinsics = { width: 4, height: 2, fx: 1, fy: 1, cx: 0, cy: 0 };
  const frame = new Frame();
  frame.setIntrinsics(intrinsics);
  frame.setDepthCamera({ intrinsics, toColour: pose });
  frame.setImage({ data: mask, width: 4, height: 2, format: 'bgr', gamma: 2.2 });
  fitter.selectView(fitter.viewCount());
  fitter.useFrame(frame, { data: mask, width: 4, height: 2, label: 3 });
  fitter.clearInput('points', 'image');
  const located: boolean = fitter.limbs().every(({ status }) => status === 'located');
  const outcomes: (Result | CylfuseError)[] = await fitAll([fitter], { threads: 2, progress: (index) => index < 3 });
  const body: boolean = fitter.pointParts(result.cylinder).every((part) => part === 'body');
  const inliers: Uint8Array = fitter.pointWeights().inliers;
  const pixels: Float64Array = projectPoints(intrinsics, unprojectPixels(intrinsics, new Float64Array(inliers.length)));
  const radius: number | undefined = located ? pixels[0] : fitter.endSamples()[0]?.deviation;
  // @ts-expect-error colours are bytes
  fitter.pushImage({ data: xyz, width: 4, height: 2, format: 'rgb' });
  // @ts-expect-error no such input
  fitter.clearInput('mask');
  // @ts-expect-error there is none in the phase start
  fitter.setProgress((progress) => progress.cylinder.radius > 0);
  // @ts-expect-error a frame cannot be described
  fitter.useFrame({ intrinsics });
  const single: Float32Array = fitter.complete({ type: Float32Array }).points;
  const double: Float64Array = fitter.complete().points;
  const stored: Uint16Array = fitter.completeDepth({ type: Uint16Array, scale: 0.001 }).depth.data;
  try {
    await fitPoints(double);
  } catch (error) {
    if (error instanceof CylfuseError && error.code === 'TOO_FEW_POINTS') return -1;
  }
  const detector = new Detector();
  detector.setOptions({ imageUse: 'ignore', maxCount: 3, axis: [0, 1, 0] });
  detector.setFitOptions({ depthNoise: 0.001 });
  detector.setProgress((progress) => progress.phase === 'search' || progress.fitsDone < progress.fits);
  const reasons: string[] = [
    ...describeFlags(result.flags), describeTermination(result.termination), describeEndState(extent.startState),
  ];
  const causes: (string | undefined)[] = detector.detections().map(({ extentError }) => extentError?.code);
  const lengths: number[] = [...await detector.detect(frame), ...detector.detectPointsSync(xyz)].map(
    ({ score, result: { radiusDeviation }, extent: ends }) => score + radiusDeviation + (ends?.length ?? 0),
  );
  const labels: Uint16Array = detector.labels().data;
  const indices: Uint32Array = detector.indices(labels.length);
  detector.fitter(indices.length + lengths.length + reasons.length + causes.length).close();
  detector.close();
  // @ts-expect-error the extent of a cloud is null
  detector.detections()[0].extent.length;
  // @ts-expect-error no such objective
  fitter.setOptions({ objective: 'best' });
  // @ts-expect-error a typed array is needed
  fitter.pushPoints([1, 2, 3]);
  // @ts-expect-error the size is missing
  fitter.pushDepth({ data: depth });
  // @ts-expect-error an asynchronous callback cannot stop a fit
  fitter.setProgress(async () => false);
  // @ts-expect-error fit is asynchronous
  fitter.fit().cylinder;
  fitter.close();
  return extent.length + (radius ?? 0) + single.length + stored.length + distances(result.cylinder, xyz).length;
}
void use;

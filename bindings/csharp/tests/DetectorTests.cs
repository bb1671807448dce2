using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace Cylfuse.Tests
{
    [Tests]
    internal static class DetectorTests
    {
        /// <summary>Checks what a detector says of both cylinders, and one thing against another.</summary>
        private static void CheckScene(Detector detector, Detection[] found, double tolerance)
        {
            ushort[] labels = detector.Labels().Cast<ushort>().ToArray();
            int[] owners = Pair.Owners.Cast<int>().ToArray();
            Check.Equal(2, found.Length, "cylinders");
            Check.Equal(owners.Length, labels.Length, "labels");
            Check.That(found[0].Score >= found[1].Score && found[1].Score >= 0.5 && found[0].Score <= 1, "scores");
            var seen = new HashSet<int>();
            for (int index = 0; index < 2; index++)
            {
                Detection one = found[index];
                int truth = Array.FindIndex(Pair.Truths, cylinder =>
                {
                    CylinderDifference difference = cylinder.Compare(one.Result.Model);
                    return difference.Angle < tolerance && difference.AxisDistance < tolerance * cylinder.Radius
                        && Math.Abs(difference.RadiusRelative) < tolerance;
                });
                Check.That(truth >= 0 && seen.Add(truth), $"radius {one.Result.Model.Radius} is none of them");
                uint[] indices = detector.Indices(index);
                uint[] labelled = Enumerable.Range(0, labels.Length).Where(k => labels[k] == index + 1)
                    .Select(k => (uint)k).ToArray();
                Check.That(indices.SequenceEqual(labelled), "indices and labels");
                Check.Equal((long)indices.Length, one.Pixels, "pixels");
                Check.That(indices.Count(k => owners[k] == truth + 1) > 0.95 * one.Pixels && one.Pixels > 300, "pixels");
                Check.Equal(StartKind.Model, one.Result.StartKind);
                Check.That(one.Result.RadiusDeviation > 0 && one.Result.PointsUsed <= one.Pixels, "result");
                if (one.Extent != null)
                    Check.Near(Pair.Lengths[truth], one.Extent.Length, 0.05 * Pair.Lengths[truth], "length");
            }
            Check.Equal(found.Sum(one => one.Pixels), labels.LongCount(label => label > 0), "labelled");
        }

        private static void Same(Detection[] expected, Detection[] actual)
        {
            Check.Equal(expected.Length, actual.Length, "cylinders");
            for (int k = 0; k < expected.Length; k++)
            {
                Check.Near(expected[k].Score, actual[k].Score, 0, "score");
                Check.Equal(expected[k].Pixels, actual[k].Pixels, "pixels");
                Check.That(expected[k].Result.Covariance.Cast<double>().SequenceEqual(
                    actual[k].Result.Covariance.Cast<double>()), "covariance");
                Check.Near(0, Pair.Dot(expected[k].Result.Model.Point, actual[k].Result.Model.Point)
                    - Pair.Dot(actual[k].Result.Model.Point, actual[k].Result.Model.Point), 0, "point");
                Check.Equal(expected[k].Extent?.Length, actual[k].Extent?.Length, "length");
            }
        }

        public static void ASearchThatWasCutShortSaysSo()
        {
            using (var detector = new Detector())
            using (Frame frame = Bumps(), pair = Pair.Frame())
            {
                Check.Fails(Status.BadState, () => { bool _ = detector.IsComplete; }, "search a frame or points first");
                detector.Detect(frame);
                Check.That(!detector.IsComplete, "cut short");
                detector.Detect(pair);
                Check.That(detector.IsComplete, "complete");
                Check.That(detector.DepthMoved.Equals((0, 0)), "not moved");
            }
        }

        public static void TheCylindersOfAFrame()
        {
            using (var detector = new Detector())
            using (Frame frame = Pair.Frame(), without = Pair.Frame(false))
            {
                Detection[] found = detector.Detect(frame);
                CheckScene(detector, found, 0.01);
                Check.Equal(2, found[0].Result.LimbsLocated);
                Check.That(found.All(one => one.Extent != null && one.ExtentError == null), "extents");
                Same(found, detector.Detections());

                // The image is not looked at: as if there were none.
                detector.Options = new DetectorOptions { ImageUse = ImageUse.Ignore };
                Detection[] ignored = detector.Detect(frame);
                CheckScene(detector, ignored, 0.1);
                detector.Options = new DetectorOptions();
                Detection[] missing = detector.Detect(without);
                Same(ignored, missing);

                // In the reference frame.
                without.SetPose(new RigidMotion(new[,] { { 0.8, 0, 0.6 }, { 0, 1, 0 }, { -0.6, 0, 0.8 } },
                    new Vector(-0.5, 0.1, 0.2)));
                Detection[] turned = detector.Detect(without);
                for (int k = 0; k < 2; k++)
                {
                    Cylinder model = missing[k].Result.Model;
                    Vector point = Turned(model.Point);
                    var there = new Cylinder(new Vector(point.X - 0.5, point.Y + 0.1, point.Z + 0.2),
                        Turned(model.Direction), model.Radius);
                    CylinderDifference difference = there.Compare(turned[k].Result.Model);
                    Check.That(difference.Angle < 1e-9 && difference.AxisDistance < 1e-9
                        && Math.Abs(difference.RadiusRelative) < 1e-9, "pose");
                }
                frame.Dispose();
                Check.Equal(2, detector.Detections().Length);
            }
        }

        private static Vector Turned(Vector x) => new Vector(0.8 * x.X + 0.6 * x.Z, x.Y, -0.6 * x.X + 0.8 * x.Z);

        public static void TheCylindersOfACloud()
        {
            using (var detector = new Detector())
            {
                Detection[] found = detector.DetectPoints(PointCloud.From(Pair.Points));
                CheckScene(detector, found, 0.1);
                Check.That(found.All(one => one.Extent.EndSource == EndSource.Points), "ends");

                // Not organised, float, one after the other with other things between them, and weights.
                double[] flat = Pair.Points.Cast<double>().ToArray();
                int[] owners = Pair.Owners.Cast<int>().ToArray();
                var mixed = new float[6 * owners.Length];
                for (int k = 0; k < owners.Length; k++)
                {
                    for (int i = 0; i < 3; i++) mixed[6 * k + i] = (float)flat[3 * k + i];
                    mixed[6 * k + 3] = 1;
                }
                PointCloud cloud = PointCloud.From(mixed, owners.Length, 1, 0, 6).WithWeights(mixed, 3, 6);
                CheckScene(detector, detector.DetectPoints(cloud), 0.1);
                Check.Equal(1, detector.Labels().GetLength(0), "rows");
                // Weights of 0 leave points out: all but those of the wall and the first cylinder.
                for (int k = 0; k < owners.Length; k++) mixed[6 * k + 3] = owners[k] == 2 ? 0 : 2;
                Check.Equal(1, detector.DetectPoints(cloud).Length);
                mixed[6 * 7 + 3] = -1;
                Check.Fails(Status.InvalidArgument, () => detector.DetectPoints(cloud), "the weight of point 7 is -1");
                Check.Equal(1, detector.Detections().Length);
            }
        }

        public static void AFitterGoesOn()
        {
            var detector = new Detector();
            Frame frame = Pair.Frame();
            Detection one = detector.Detect(frame)[1];
            Fitter fitter = detector.MakeFitter(1);
            detector.Dispose();
            frame.Dispose();
            using (fitter)
            {
                Check.Equal(Pair.Camera, fitter.Intrinsics);
                Check.Near(one.Result.Model.Radius, fitter.Result().Model.Radius, 0, "radius");
                Check.Near(one.Extent.Length, fitter.Extent().Length, 0, "length");
                Check.That(fitter.Limbs().All(limb => limb.Status == LimbStatus.Located), "limbs");
                Check.Equal(one.Result.PointsUsed, (long)fitter.Residuals(ResidualKind.Points).Length, "residuals");
                Check.Equal(Pair.Width, fitter.CompleteDepth().Depth.GetLength(1), "columns");
                Check.Equal(StartKind.Model, fitter.Options.Start);
                // The same fit once more.
                Check.Near(one.Result.Model.Radius, fitter.Fit().Model.Radius, 0, "radius");
            }
            using (var another = new Detector())
            {
                Detection[] found = another.DetectPoints(PointCloud.From(Pair.Points));
                using (Fitter ofPoints = another.MakeFitter(0))
                {
                    // Fitted to its whole region: its points share no errors.
                    Check.Equal((long)found[0].Pixels, (long)ofPoints.Counts().PointsUsed, "points");
                    Check.That(ofPoints.Intrinsics == null, "a cloud has a camera");
                }
                const string text = "index is 2; it must be less than the number of cylinders, 2";
                Check.Fails(Status.InvalidArgument, () => another.MakeFitter(2), text);
                Check.Fails(Status.InvalidArgument, () => another.Indices(2), text);
                Check.Throws<ArgumentOutOfRangeException>(() => another.Indices(-1), "-1");
                Check.Throws<ArgumentOutOfRangeException>(() => another.MakeFitter(-1), "-1");
            }
        }

        public static void LimitsHold()
        {
            using (var detector = new Detector())
            using (Frame frame = Pair.Frame())
            {
                detector.Options = new DetectorOptions
                {
                    RadiusMin = 0.04, RadiusMax = 0.06, Axis = new Vector(0, -3, 0), AxisMaxAngle = 0.2,
                };
                foreach (Detection[] found in new[] { detector.Detect(frame), detector.DetectPoints(PointCloud.From(Pair.Points)) })
                {
                    Check.Equal(1, found.Length, "cylinders");
                    Check.Near(0.05, found[0].Result.Model.Radius, 0.005, "radius");
                }
                Check.Near(-3, detector.Options.Axis.Y, 0, "axis");
                detector.Options = new DetectorOptions { MinPixels = ulong.MaxValue };
                Check.Equal(0, detector.Detect(frame).Length);
                Check.That(detector.Labels().Cast<ushort>().All(label => label == 0), "labels");
                Check.Fails(Status.InvalidArgument, () => detector.Options = new DetectorOptions { MinScore = 1.5 },
                    "options.min_score is 1.5");
                Check.Equal(ulong.MaxValue, detector.Options.MinPixels);
                detector.FitOptions = new FitOptions { DepthNoise = 0.001 };
                foreach (FitOptions refused in new[] { new FitOptions { Start = StartKind.Moments },
                    new FitOptions { MaxThreads = 2 }, new FitOptions { RadiusMax = 0.1 } })
                    Check.Fails(Status.InvalidArgument, () => detector.FitOptions = refused, "of the fits");
                Check.Near(0.001, detector.FitOptions.DepthNoise, 0, "depth noise");
                detector.Options = new DetectorOptions();
                detector.FitOptions = new FitOptions { Objective = Objective.Paper };
                Check.Fails(Status.Unsupported, () => detector.Detect(frame));
            }
        }

        public static void AnyNumberOfThreadsGivesTheSameBits()
        {
            using (Detector one = new Detector(), three = new Detector { Options = new DetectorOptions { MaxThreads = 3 } })
            using (Frame frame = Pair.Frame()) Same(one.Detect(frame), three.Detect(frame));
        }

        public static void SomeCallsNeedASearch()
        {
            var detector = new Detector();
            foreach (Action call in new Action[] { () => detector.Detections(), () => detector.Labels(),
                () => detector.Indices(0), () => detector.MakeFitter(0) })
                Check.Fails(Status.BadState, call, "search a frame or points first");
            using (var frame = new Frame())
            {
                Check.Fails(Status.BadState, () => detector.Detect(frame), "intrinsics");
                frame.Intrinsics = Pair.Camera;
                Check.Fails(Status.BadState, () => detector.Detect(frame), "depth");
                frame.Dispose();
                Check.Throws<ObjectDisposedException>(() => detector.Detect(frame), "Frame");
            }
            Check.Throws<ArgumentNullException>(() => detector.Detect(null), "frame");
            Check.Throws<ArgumentNullException>(() => detector.DetectPoints(null), "points");
            Check.Equal(0, detector.DetectPoints(PointCloud.From(new double[0, 3])).Length);
            Check.Equal(0, detector.Labels().Length);
            detector.Dispose();
            detector.Dispose();
            Check.Throws<ObjectDisposedException>(() => detector.Labels(), "Detector");
            Check.Throws<ObjectDisposedException>(() => detector.DetectPoints(PointCloud.From(Pair.Points)), "Detector");
        }

        public static void ProgressIsToldAndStops()
        {
            using (var detector = new Detector())
            using (Frame frame = Pair.Frame())
            {
                var states = new List<DetectionProgress>();
                detector.SetProgress(state =>
                {
                    states.Add(state);
                    Check.Fails(Status.Busy, () => detector.Labels());
                    Check.Fails(Status.Busy, () => detector.Detect(frame));
                    return true;
                });
                Detection[] found = detector.Detect(frame);
                Check.Equal(DetectionPhase.Search, states[0].Phase);
                Check.Equal(DetectionPhase.Fit, states[1].Phase);
                Check.Equal(states.Count - 2, states.Last().FitsDone);
                Check.Equal(states.Last().Fits, states.Last().FitsDone);
                detector.SetProgress(state => false);
                Check.Fails(Status.Cancelled, () => detector.Detect(frame), "cancelled by the caller");
                detector.SetProgress(state => { detector.Cancel(); return true; });
                Check.Fails(Status.Cancelled, () => detector.Detect(frame));
                detector.SetProgress(state => throw new InvalidOperationException("of the caller"));
                Check.Throws<InvalidOperationException>(() => detector.Detect(frame), "of the caller");
                var source = new CancellationTokenSource();
                detector.SetProgress(state => { source.Cancel(); return true; });
                Check.Throws<OperationCanceledException>(() => detector.Detect(frame, source.Token), "");
                // The last scene is still there.
                detector.SetProgress(null);
                Same(found, detector.Detections());
                Check.Throws<OperationCanceledException>(() => detector.Detect(frame, source.Token), "");
                detector.Cancel();
                Same(found, detector.Detect(frame, new CancellationTokenSource().Token));
            }
        }

        /// <summary>Bumps in both directions, 12 pixels apart: more to look at than a search may.</summary>
        private static Frame Bumps()
        {
            var bumps = new float[480, 640];
            for (int row = 0; row < 480; row++)
                for (int column = 0; column < 640; column++)
                    bumps[row, column] =
                        (float)(1 + 1.2 / 525 * Math.Sin(Math.PI / 6 * column) * Math.Sin(Math.PI / 6 * row));
            var frame = new Frame { Intrinsics = new Intrinsics(640, 480, 525, 525, 319.5, 239.5) };
            frame.SetDepth(DepthImage.From(bumps, 1));
            return frame;
        }

        public static void ATokenStopsASearchBetweenItsReports()
        {
            using (var detector = new Detector())
            using (Frame frame = Bumps())
            {
                var reports = new List<TimeSpan>();
                var time = Stopwatch.StartNew();
                detector.SetProgress(state => { reports.Add(time.Elapsed); return true; });
                detector.Detect(frame);
                TimeSpan quiet = reports[1] - reports[0];

                foreach (bool here in new[] { true, false })
                    using (var source = new CancellationTokenSource())
                    {
                        reports.Clear();
                        detector.SetProgress(state =>
                        {
                            reports.Add(time.Elapsed);
                            // The callback asked the token before.
                            if (here) source.Cancel();
                            else source.CancelAfter(1);
                            return true;
                        });
                        Check.Throws<OperationCanceledException>(() => detector.Detect(frame, source.Token), "");
                        Check.Equal(1, reports.Count, "reports");
                        TimeSpan taken = time.Elapsed - reports[0];
                        Check.That(taken.Ticks < quiet.Ticks / 2, $"stopped after {taken}, reports are {quiet} apart");
                    }
            }
        }

        public static void ADetectorThatIsDisposedMeanwhileIsStoppedByItsToken()
        {
            var detector = new Detector();
            using (Frame frame = Pair.Frame())
            using (var source = new CancellationTokenSource())
            {
                detector.SetProgress(state => { detector.Dispose(); source.Cancel(); return true; });
                Check.Throws<OperationCanceledException>(() => detector.Detect(frame, source.Token), "");
                Check.Throws<ObjectDisposedException>(() => detector.Detect(frame), "Detector");
            }
        }

        /// <summary>test.sh makes a library that finds no extents.</summary>
        public static void AMissingExtentHasItsReason() =>
            Check.Equal("2 EdgeGeometry EDGE_GEOMETRY: made up\n", LoadingTests.Run(
                Environment.GetEnvironmentVariable("CYLFUSE_WITHOUT_EXTENTS"), nameof(PrintMissingExtents)));

        /// <summary>In the other process.</summary>
        internal static int PrintMissingExtents()
        {
            using (var detector = new Detector())
            using (Frame frame = Pair.Frame())
            {
                Detection[] found = detector.Detect(frame);
                CylfuseException error = found[1].ExtentError;
                Console.WriteLine($"{found.Count(one => one.Extent == null)} {error.Status} {error.Message}");
            }
            return 0;
        }

        public static void ASearchInAnotherThread()
        {
            using (var detector = new Detector())
            using (Frame frame = Pair.Frame())
            {
                var inside = new ManualResetEventSlim();
                var tried = new ManualResetEventSlim();
                detector.SetProgress(state => { inside.Set(); tried.Wait(); return true; });
                Task search = Task.Factory.StartNew(() => Check.Fails(Status.Cancelled, () => detector.Detect(frame)),
                    TaskCreationOptions.LongRunning);
                inside.Wait();
                Check.Fails(Status.Busy, () => detector.Detect(frame));
                Check.Fails(Status.Busy, () => detector.Labels());
                Check.Fails(Status.Busy, () => detector.Options.ToString());
                detector.Cancel();
                tried.Set();
                search.Wait();
            }
        }

        public static void ManyThreadsReadAScene()
        {
            using (var detector = new Detector())
            using (Frame frame = Pair.Frame())
            {
                Detection[] found = detector.Detect(frame);
                Task.WaitAll(Enumerable.Range(0, 4).Select(k => Task.Factory.StartNew(() =>
                {
                    for (int round = 0; round < 10; round++)
                    {
                        Same(found, detector.Detections());
                        Check.Equal(found[1].Pixels, (long)detector.Indices(1).Length, "indices");
                        detector.MakeFitter(1).Dispose();
                    }
                }, TaskCreationOptions.LongRunning)).ToArray());
            }
        }

        public static void TheGarbageCollectorFreesDetectors()
        {
            PointCloud cloud = PointCloud.From(new double[480, 640, 3]);
            Forget(cloud, 40);
            // Their labels alone would be 88 MB.
            LifetimeTests.MemoryStaysFlat(60, () => { for (int round = 0; round < 15; round++) Forget(cloud, 10); });
        }

        private static void Forget(PointCloud cloud, int count)
        {
            for (int k = 0; k < count; k++)
            {
                var detector = new Detector();
                // A callback that knows its detector does not keep it alive.
                detector.SetProgress(state => detector != null);
                detector.DetectPoints(cloud);
            }
            GC.Collect();
            GC.WaitForPendingFinalizers();
        }
    }
}

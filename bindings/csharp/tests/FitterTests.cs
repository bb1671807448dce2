using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace Cylfuse.Tests
{
    [Tests]
    internal static class FitterTests
    {
        public static void TheLibrarySaysWhatItIs()
        {
            Check.Equal(1, Library.AbiVersion);
            string[] parts = Library.VersionString.Split('.');
            Check.Equal(int.Parse(parts[0]) * 65536 + int.Parse(parts[1]) * 256 + int.Parse(parts[2]),
                Library.VersionNumber);
            Check.That(Library.BuildInfo.Contains(Library.VersionString), Library.BuildInfo);
            Check.That(Library.StatusText(Status.PlanarPoints).StartsWith("PLANAR_POINTS:"),
                Library.StatusText(Status.PlanarPoints));
        }

        public static void PointsGiveTheCylinder()
        {
            using (var fitter = new Fitter())
            {
                fitter.PushPoints(PointCloud.From(Scene.Pipe()));
                FitResult result = fitter.Fit();
                Check.Near(0.5, result.Model.Radius, 1e-9, "radius");
                Check.Near(1.0, result.Model.Direction.Y, 1e-12, "direction");
                Check.Equal(200L, result.PointsUsed);
                Check.Equal(ResultFlags.None, result.Flags);
                Check.Near(result.Cost, fitter.Result().Cost, 0, "stored result");
                Check.Near(result.RadiusDeviation, Math.Sqrt(result.Covariance[6, 6]), 1e-15, "covariance");
            }
        }

        public static void AllArraysOfTheSamePointsGiveTheSameBits()
        {
            double[,] rows = Scene.Pipe();
            double[] flat = rows.Cast<double>().ToArray();
            var grid = new double[10, 20, 3];
            Buffer.BlockCopy(rows, 0, grid, 0, Buffer.ByteLength(rows));
            var strided = new double[5 + 200 * 4];
            for (int k = 0; k < 600; k++) strided[5 + k / 3 * 4 + k % 3] = flat[k];
            var reversed = new double[600];
            for (int k = 0; k < 600; k++) reversed[(199 - k / 3) * 3 + k % 3] = flat[k];
            double radius = Radius(PointCloud.From(rows));
            Check.Near(radius, Radius(PointCloud.From(flat)), 0, "flat");
            Check.Near(radius, Radius(PointCloud.From(grid)), 0, "grid");
            Check.Near(radius, Radius(PointCloud.From(strided, 200, 1, 5, 4)), 0, "strided");
            Check.Near(radius, Radius(PointCloud.From(strided, 20, 10, 5, 4, 80)), 0, "strided rows");
            Check.Near(radius, Radius(PointCloud.From(reversed, 200, 1, 597, -3)), 0, "backwards");
            Check.Near(radius, Radius(PointCloud.From(rows).WithWeights(Enumerable.Repeat(1.0, 200).ToArray())), 0,
                "weights");
            float[] single = flat.Select(x => (float)x).ToArray();
            Check.Near(0.5, Radius(PointCloud.From(single)), 1e-6, "float");
        }

        /// <summary>.NET lets an array of signed numbers pass for one of unsigned ones.</summary>
        public static void SignedArraysAreReadAsUnsigned()
        {
            using (Fitter expected = Scene.Loaded())
            using (var fitter = new Fitter { Intrinsics = Scene.Camera })
            {
                var depth = new short[Scene.Height, Scene.Width];
                Buffer.BlockCopy(Scene.Depth(), 0, depth, 0, 2 * depth.Length);
                fitter.PushDepth(DepthImage.From((ushort[,])(object)depth, 1e-4), Mask.From(Scene.Mask()));
                fitter.PushEdges(Scene.Edges());
                fitter.PushImage(Image.From((byte[,])(object)new sbyte[Scene.Height, Scene.Width]));
                expected.PushImage(Image.From(new byte[Scene.Height, Scene.Width]));
                Check.Near(expected.Fit().Cost, fitter.Fit().Cost, 0, "cost");
            }
        }

        public static void ArraysBeyondTwoGigabytesAreTaken()
        {
            using (var fitter = new Fitter())
            {
                // Never touched, so that it takes no memory.
                fitter.PushPoints(PointCloud.From(new double[270000000], 10, 1, 269999970));
                Check.Equal(10L, fitter.Counts().PointsGiven);
            }
        }

        public static void EmptyArraysAreNothing()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                long given = fitter.Counts().PointsGiven;
                fitter.PushPoints(PointCloud.From(new double[0, 3]));
                fitter.PushPoints(PointCloud.From(new float[0]));
                fitter.PushEdges(new double[0, 4]);
                Check.Equal(given, fitter.Counts().PointsGiven);
                Check.Equal(0, fitter.SelectEdges(Segments.From(new double[0, 4]), Scene.Truth).Length);
                Check.Equal(0, Scene.Truth.Distances(PointCloud.From(new double[0, 3])).Length);
                Check.Fails(Status.SizeMismatch, () => fitter.PushImage(Image.From(new byte[0, 0])), "0 x 0");
            }
        }

        private static double Radius(PointCloud points)
        {
            using (var fitter = new Fitter())
            {
                fitter.PushPoints(points);
                return fitter.Fit().Model.Radius;
            }
        }

        public static void WeightsAndMasksSelectPoints()
        {
            using (var fitter = new Fitter())
            {
                var weights = Enumerable.Range(0, 200).Select(k => k % 2 == 0 ? 1.0 : 0.0).ToArray();
                fitter.PushPoints(PointCloud.From(Scene.Pipe()).WithWeights(weights));
                Counts counts = fitter.Counts();
                Check.Equal(200L, counts.PointsGiven);
                Check.Equal(100L, counts.DroppedZeroWeight);
                fitter.Clear();
                var mask = new bool[1, 200];
                for (int k = 0; k < 50; k++) mask[0, k] = true;
                fitter.PushPoints(PointCloud.From(Scene.Pipe()), Mask.From(mask));
                Check.Equal(150L, fitter.Counts().DroppedOutsideMask);
            }
        }

        public static void ADepthImageGivesEverything()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                FitResult result = fitter.Fit();
                CylinderDifference difference = Scene.Truth.Compare(result.Model);
                Check.That(difference.Angle < 1e-3 && difference.AxisDistance < 1e-4, "axis");
                Check.Near(0, difference.RadiusRelative, 1e-3, "radius");
                Check.Equal(2, result.SegmentsUsed);
                Check.That(result.StartKind != StartKind.Auto, "start");

                double[] residuals = fitter.Residuals(ResidualKind.Points);
                Check.Equal(result.PointsUsed, (long)residuals.Length);
                Check.Near(result.PointRms, Math.Sqrt(residuals.Sum(r => r * r) / residuals.Length), 1e-12, "rms");
                Check.Equal(4, fitter.Residuals(ResidualKind.Edges).Length);
                Check.Equal(5, fitter.Diagnose().Rank);
                Check.Equal(0, fitter.LimbSamples().Length);

                Extent extent = fitter.Extent();
                Check.Equal(extent.EndState, fitter.Extent(model: result.Model).EndState);
                Check.That(extent.Length > 0.2 && extent.Length < 1, "length");

                CompletedCloud<double> cloud = fitter.Complete();
                Check.Equal(cloud.Pixels.Count, (long)cloud.Width);
                Check.Equal(fitter.CompleteBound(), cloud.Pixels.Hits + cloud.Pixels.Misses);
                double[] distances = result.Model.Distances(PointCloud.From(cloud.Coordinates));
                Check.That(distances.All(d => Math.Abs(d) < 1e-12), "a completed point is off the surface");
                CompletedCloud<float> organised = fitter.CompleteSingle(Layout.Organised);
                Check.Equal((long)Scene.Width * Scene.Height * 3, organised.Coordinates.Length);
                Check.Equal((int)cloud.Pixels.Count, organised.Coordinates.Count(x => !float.IsNaN(x)) / 3);

                CompletedDepth<float> depth = fitter.CompleteDepth();
                CompletedDepth<ushort> integers = fitter.CompleteDepthUInt16(1e-4);
                Check.Equal(cloud.Pixels.Count, (long)depth.Depth.Cast<float>().Count(z => z > 0));
                for (int v = 0; v < Scene.Height; v++)
                    for (int u = 0; u < Scene.Width; u++)
                        Check.Near(depth.Depth[v, u], integers.Depth[v, u] * 1e-4, 6e-5, "depth");
            }
        }

        public static void EdgesOfADetectorAreSelected()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                double[,] edges = Scene.Edges();
                var found = new double[3, 4];
                for (int k = 0; k < 4; k++)
                {
                    found[0, k] = k % 2 == 0 ? 2 : 10 + 20 * k; // the border of the image
                    found[1, k] = edges[1, k];
                    found[2, k] = edges[0, k];
                }
                byte[] limbs = fitter.SelectEdges(Segments.From(found), Scene.Truth);
                Check.That(limbs.SequenceEqual(new byte[] { 0, 2, 1 }), string.Join(" ", limbs));
                Check.Fails(Status.BadState, () => fitter.SelectEdges(Segments.From(found)), "model");
                Check.Fails(Status.InvalidArgument, () => fitter.SelectEdges(Segments.From(found), Scene.Truth, -1),
                    "-1");
            }
        }

        public static void TheImageIsSearchedForLimbs()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                byte[,] mask = Scene.Mask();
                var image = new float[Scene.Height, Scene.Width];
                for (int v = 0; v < Scene.Height; v++)
                    for (int u = 0; u < Scene.Width; u++)
                        image[v, u] = mask[v, u] > 0 ? 200 : 50;
                Image coded = Image.From(image);
                coded.Gamma = 22;
                Check.Fails(Status.InvalidArgument, () => fitter.PushImage(coded), "gamma of the image is 22");
                fitter.PushImage(Image.From(image));
                FitResult result = fitter.Fit();
                Check.That(fitter.LimbSamples().Length > 0, "no samples");
                Check.Equal(fitter.LimbSamples().Any(sample => sample.Weight > 0), result.LimbsLocated > 0, "limbs");
            }
        }

        public static void OptionsRoundTripAndCount()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                var options = new FitOptions
                {
                    Method = Method.Fused, Objective = Objective.Paper, Start = StartKind.Model,
                    NearWall = NearWall.On, Chart = Chart.Local, MaxIterations = 123, MaxThreads = 2,
                    EdgeWeight = 0.25, InitialLambda = 0.5, LambdaFactor = 3, MaxLambda = 1e9, CostTolerance = 1e-11,
                    RansacThreshold = 0.125, Seed = 77, RansacMaxIterations = 321, EdgeUse = EdgeUse.AsGiven,
                    ExtentRule = ExtentRule.Extremes, RadiusMin = 0.05, RadiusMax = 0.0625,
                    Axis = new Vector(0, 1, 0.5), AxisMaxAngle = 0.75, GradientTolerance = 1e-9, StepTolerance = 1e-10,
                    IndependentPoints = 500, DepthNoise = 2e-3, ImageNoise = 3, EdgeNoise = 0.75, MaskNoise = 2,
                    ImageBlur = 1.25, DrawnPixel = 1.5, DepthShared = 0.004,
                };
                fitter.Options = options;
                FitOptions read = fitter.Options;
                foreach (var property in typeof(FitOptions).GetProperties())
                    Check.Equal(property.GetValue(options), property.GetValue(read), property.Name);
                fitter.SetStartModel(Scene.Truth);
                FitResult result = fitter.Fit();
                Check.Equal(StartKind.Model, result.StartKind);
                Check.Near(0.0625, result.Model.Radius, 1e-15, "limit");
                Check.That((result.Flags & ResultFlags.RadiusAtLimit) != 0, "flag");
                Check.Near(0.25, result.EdgeWeight, 0, "edge weight");
            }
        }

        public static void EvaluateDoesNotIterate()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                FitResult result = fitter.Evaluate(Scene.Truth);
                Check.Equal(Termination.None, result.Termination);
                Check.Equal(0, result.Iterations);
                Check.Fails(Status.BadState, () => fitter.Result());
            }
        }

        public static void FailuresHaveTheKindAndTheMessageOfTheLibrary()
        {
            using (var fitter = new Fitter())
            {
                Check.Throws<UnusableDataException>(() => fitter.Fit(), "point");
                fitter.PushPoints(PointCloud.From(new double[4, 3]));
                Check.Fails(Status.TooFewPoints, () => fitter.Fit(), "4");
                Check.Fails(Status.BadState, () => fitter.PushDepth(DepthImage.From(Scene.Depth(), 1e-4)),
                    "intrinsics");
                Check.Fails(Status.BadState, () => fitter.CompleteDepth());
                Check.Fails(Status.BadState, () => fitter.Complete());
                Check.Fails(Status.InvalidIntrinsics, () =>
                    fitter.Intrinsics = new Intrinsics(10, 10, double.NaN, 1, 0, 0), "NaN");
                Check.Fails(Status.InvalidArgument, () => fitter.Options = new FitOptions { EdgeWeight = 2 }, "2");
                Check.Fails(Status.InvalidArgument, () => fitter.Options = new FitOptions { Method = (Method)99 },
                    "99");
                Check.Fails(Status.InvalidArgument, () => fitter.PushEdges(new[,] { { double.NaN, 0, 1, 1 } }), "NaN");
                Check.Fails(Status.InvalidArgument, () =>
                    Scene.Truth.Compare(new Cylinder(new Vector(), new Vector(), 1)));
                fitter.Intrinsics = Scene.Camera;
                Check.Fails(Status.SizeMismatch, () => fitter.PushDepth(DepthImage.From(new ushort[3, 4], 1)), "4");
                Check.Fails(Status.EmptyMask, () =>
                    fitter.PushDepth(DepthImage.From(Scene.Depth(), 1e-4),
                        Mask.From(new byte[Scene.Height, Scene.Width])));
            }
        }

        public static void WrongShapesAreRefusedBeforeTheCall()
        {
            Check.Throws<ArgumentException>(() => PointCloud.From(new double[5, 2]), "must be 3");
            Check.Throws<ArgumentException>(() => PointCloud.From(new double[7]), "multiple of 3");
            Check.Throws<ArgumentException>(() => PointCloud.From(new double[30], 10, 1, 1),
                "elements 1 to 30 of an array that has 30");
            Check.Throws<ArgumentException>(() => PointCloud.From(new double[30], 10, 1, 0, -3), "elements -27 to 2");
            Check.Throws<ArgumentException>(() => PointCloud.From(new double[30], int.MaxValue, int.MaxValue),
                "elements");
            Check.Throws<ArgumentException>(() => PointCloud.From(new double[30]).WithWeights(new float[10]),
                "same type");
            Check.Throws<ArgumentException>(() => PointCloud.From(new double[30]).WithWeights(new double[9]),
                "weights");
            Check.Throws<ArgumentException>(() => DepthImage.From(new ushort[11], 4, 3, 1.0), "elements 0 to 11");
            Check.Throws<ArgumentException>(() => Mask.From(new byte[12], 4, -3), "negative");
            Check.Throws<ArgumentException>(() => Image.From(new byte[33], 4, 3, 0, 3),
                "elements 0 to 33 of an array that has 33");
            Check.Throws<ArgumentException>(() => Segments.From(new double[2, 3]), "must be 4");
            Check.Throws<ArgumentException>(() => Segments.From(new double[2, 4]).WithWeights(new double[3]),
                "3 weights for 2 segments");
            Check.Throws<ArgumentException>(() =>
                new Intrinsics(1, 1, 1, 1, 0, 0, DistortionModel.BrownConrady, new double[9]), "at most 8");
            Check.Throws<ArgumentNullException>(() => PointCloud.From((double[,])null), "");
        }

        public static void CallbacksHearAndStop()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                var phases = new List<Phase>();
                fitter.SetProgress(progress => { phases.Add(progress.Phase); return true; });
                var lines = new List<string>();
                fitter.SetLog(LogLevel.Info, (level, line) => lines.Add(line));
                fitter.Fit();
                Check.That(phases.First() == Phase.Start && phases.Contains(Phase.Solve), "phases");
                Check.That(lines.Count > 0 && lines.All(line => line.Length > 0), "lines");
                fitter.SetLog(LogLevel.Off, null);

                fitter.SetProgress(progress => false);
                Check.Fails(Status.Cancelled, () => fitter.Fit());
                fitter.SetProgress(progress => { Throw(); return true; });
                Check.Throws<FormatException>(() => fitter.Fit(), "from the callback");
                fitter.SetProgress(null);
                fitter.SetLog(LogLevel.Debug, (level, line) => Throw());
                Check.Throws<FormatException>(() => fitter.Fit(), "from the callback");
                fitter.SetLog(LogLevel.Off, null);
                fitter.SetProgress(progress => { fitter.Clear(); return true; });
                Check.Fails(Status.Busy, () => fitter.Fit(), "busy");
                fitter.SetProgress(null);
                fitter.Cancel(); // no fit is running: nothing happens
                Check.Near(Scene.Truth.Radius, fitter.Fit().Model.Radius, 1e-3, "after all that");
            }
        }

        private static void Throw() => throw new FormatException("from the callback");

        public static void ATokenCancelsAFit()
        {
            using (Fitter fitter = Scene.Loaded())
            using (var source = new CancellationTokenSource())
            {
                fitter.SetProgress(progress => { source.Cancel(); return true; });
                Check.Throws<OperationCanceledException>(() => fitter.Fit(source.Token), "");
                fitter.SetProgress(null);
                Check.Throws<OperationCanceledException>(() => fitter.Fit(source.Token), "");
                fitter.Fit();
            }
        }

        public static void ATokenThatComesLateStopsNoOtherCall()
        {
            using (Fitter fitter = Scene.Loaded())
            using (var started = new AutoResetEvent(false))
            {
                int stopped = 0;
                for (int round = 0; round < 50; round++)
                {
                    using (var source = new CancellationTokenSource())
                    {
                        int turns = 2000 * round;
                        Task cancelling = Task.Run(() => { started.WaitOne(); Thread.SpinWait(turns); source.Cancel(); });
                        started.Set();
                        try { fitter.Fit(source.Token); }
                        catch (OperationCanceledException) { stopped++; }
                        // With the same fitter at once, and without the token.
                        Check.Near(Scene.Truth.Radius, fitter.Fit().Model.Radius, 1e-3, "radius");
                        cancelling.Wait();
                    }
                }
                Check.That(stopped > 0, "none was stopped");
            }
        }

        public static void ConstantsAreDescribed()
        {
            Each<Termination>(constant => constant.Describe());
            Each<StartKind>(constant => constant.Describe());
            Each<EndState>(constant => constant.Describe());
            Each<EndSource>(constant => constant.Describe());
            Each<LimbStatus>(constant => constant.Describe());
            Each<Part>(constant => constant.Describe());
            Each<Conformity>(constant => constant.Describe());
            Each<ResultFlags>(flag => flag == ResultFlags.None ? "NONE: no warning" : flag.Describe().Single());
            string[] both = (ResultFlags.PoorFit | ResultFlags.WeakRadius).Describe();
            Check.Equal(2, both.Length);
            Check.That(both[0].StartsWith("WEAK_RADIUS: ") && both[1].StartsWith("POOR_FIT: "), string.Join("; ", both));
            Check.Equal(0, ResultFlags.None.Describe().Length);
            Check.Equal(1, ((ResultFlags)(1u << 31)).Describe().Length);
        }

        /// <summary>Checks that the text of each constant begins with its name.</summary>
        private static void Each<T>(Func<T, string> describe)
        {
            foreach (T constant in Enum.GetValues(typeof(T)))
            {
                string[] parts = describe(constant).Split(':');
                Check.Equal(constant.ToString().ToUpperInvariant(), parts[0].Replace("_", ""));
                Check.That(parts[1].Length > 5, parts[1]);
            }
        }
    }
}

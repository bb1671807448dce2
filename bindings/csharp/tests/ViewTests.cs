using System;
using System.Linq;
using System.Threading.Tasks;

namespace Cylfuse.Tests
{
    /// <summary>Views, frames, depth cameras, colour, and reading from many threads.</summary>
    [Tests]
    internal static class ViewTests
    {
        public static void TwoViewsGiveOneCylinder()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                Check.Equal(1, fitter.ViewCount);
                long first = fitter.Counts().PointsUsed;
                fitter.SelectView(1);
                Check.Equal(2, fitter.ViewCount);
                Check.That(fitter.Intrinsics == null, "a new view has no camera");
                Scene.PushView(fitter, Scene.Aside);
                long second = fitter.Counts().PointsUsed;
                Check.Equal(1, fitter.Counts().View);

                FitResult result = fitter.Fit();
                CylinderDifference difference = Scene.Truth.Compare(result.Model);
                Check.That(difference.Angle < 1e-3 && difference.AxisDistance < 1e-4, "axis");
                Check.Near(0, difference.RadiusRelative, 1e-3, "radius");
                Check.Equal(first + second, result.PointsUsed);
                Check.That(result.PointDeviation > 0 && result.IndependentPoints > 0, "scale of the points");

                PointWeights weights = fitter.PointWeights();
                Check.Equal(second, (long)weights.Weights.Length);
                Check.Equal(second, (long)fitter.Residuals(ResidualKind.Points).Length);
                Check.That(weights.Weights.Zip(weights.Inliers, (weight, inlier) => weight > 0 == inlier).All(x => x), "inliers");
                Part[] parts = fitter.PointParts();
                Check.Equal(second, (long)parts.Length);
                Check.Equal(Part.Body, parts[parts.Length / 2]);
                Check.Equal("0 0 1 1", string.Join(" ", fitter.Limbs().Select(limb => limb.View)));
                Check.That(fitter.Limbs().All(limb => limb.Status == LimbStatus.NotSearched), "there is no image");

                // The points of both views are in the reference frame.
                for (int view = 0; view < 2; view++)
                {
                    fitter.SelectView(view);
                    double[] distances = result.Model.Distances(PointCloud.From(fitter.Complete().Coordinates));
                    Check.That(distances.Length > 0 && distances.All(d => Math.Abs(d) < 1e-12), "a completed point");
                }
                Extent extent = fitter.Extent();
                Check.That(extent.StartView < 2 && extent.EndView < 2 && extent.Length > 0.2, "extent");

                Check.Fails(Status.InvalidArgument, () => fitter.SelectView(5), "5");
                Check.Throws<ArgumentOutOfRangeException>(() => fitter.SelectView(-1), "-1");
                fitter.Clear();
                Check.Equal(1, fitter.ViewCount);
                Check.Equal(Scene.Camera, fitter.Intrinsics);
            }
        }

        public static void PosesAreChecked()
        {
            using (var fitter = new Fitter())
            {
                var bent = new double[,] { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 2 } };
                Check.Fails(Status.InvalidArgument, () => fitter.SetPose(new RigidMotion(bent, new Vector())), "rotation");
                Check.Fails(Status.InvalidArgument, () =>
                    fitter.SetPose(new RigidMotion(RigidMotion.Identity.Rotation, new Vector(double.NaN, 0, 0))));
                Check.Throws<ArgumentException>(() => new RigidMotion(new double[2, 3], new Vector()), "2 x 3");
            }
        }

        public static void TwoFittersShareAFrame()
        {
            using (Fitter pushed = Scene.Loaded())
            using (Fitter one = new Fitter(), other = new Fitter())
            {
                pushed.ClearInput(Inputs.Edges);
                pushed.PushImage(Image.From(Scene.Grey()));
                var frame = new Frame();
                Check.Fails(Status.BadState, () => frame.SetDepth(DepthImage.From(Scene.Depth(), 1e-4)), "intrinsics");
                Check.Fails(Status.BadState, () => one.UseFrame(frame), "intrinsics");
                frame.Intrinsics = Scene.Camera;
                frame.SetPose(RigidMotion.Identity);
                frame.SetDepth(DepthImage.From(Scene.Depth(), 1e-4));
                frame.SetImage(Image.From(Scene.Grey()));
                Mask mask = Mask.From(Scene.Mask());
                Check.Fails(Status.SizeMismatch, () => one.UseFrame(frame, Mask.From(new byte[,] { { 1, 1 } })), "2 x 1");
                one.UseFrame(frame, mask);
                other.UseFrame(frame, mask);
                Check.Equal(Scene.Camera, other.Intrinsics);
                frame.Dispose();
                frame.Dispose();
                Check.Throws<ObjectDisposedException>(() => other.UseFrame(frame, mask), "Frame");
                FitResult expected = pushed.Fit();
                foreach (Fitter fitter in new[] { one, other })
                {
                    Check.Near(expected.Model.Radius, fitter.Fit().Model.Radius, 0, "radius");
                    Check.Near(pushed.Extent().Length, fitter.Extent().Length, 0, "length");
                    Check.Equal(fitter.Complete().Pixels.Count, pushed.Complete().Pixels.Count);
                }
            }
        }

        public static void ADepthCameraOfItsOwnIsUsed()
        {
            using (var fitter = new Fitter { Intrinsics = Scene.Camera })
            {
                var toColour = new RigidMotion(RigidMotion.Identity.Rotation, new Vector(0.02, 0, 0));
                fitter.SetDepthCamera(Scene.Camera, toColour);
                fitter.PushDepth(DepthImage.From(Scene.Depth(Scene.Seen(toColour)), 1e-4), Mask.From(Scene.Mask()));
                CylinderDifference difference = Scene.Truth.Compare(fitter.Fit().Model);
                Check.That(difference.AxisDistance < 1e-3 && Math.Abs(difference.RadiusRelative) < 5e-3, "cylinder");
                Check.Fails(Status.InvalidIntrinsics, () => fitter.SetDepthCamera(new Intrinsics(9, 9, 0, 1, 0, 0)), "0");
                fitter.ClearInput(Inputs.Depth);
                fitter.SetDepthCamera(null);
            }
        }

        public static void ColourImagesAreTaken()
        {
            byte[,] grey = Scene.Grey();
            var rgb = new byte[Scene.Height, Scene.Width, 3];
            var bgr = new byte[Scene.Height, Scene.Width, 3];
            var bgra = new byte[Scene.Height * Scene.Width * 4];
            for (int v = 0; v < Scene.Height; v++)
                for (int u = 0; u < Scene.Width; u++)
                {
                    rgb[v, u, 0] = bgr[v, u, 2] = bgra[4 * (v * Scene.Width + u) + 2] = grey[v, u];
                    rgb[v, u, 1] = bgr[v, u, 1] = bgra[4 * (v * Scene.Width + u) + 1] = 7;
                }
            double radius = Radius(Image.From(rgb, ColourFormat.Rgb8));
            Check.Near(radius, Radius(Image.From(bgr, ColourFormat.Bgr8)), 0, "BGR");
            Check.Near(radius, Radius(Image.From(bgra, Scene.Width, Scene.Height, ColourFormat.Bgra8)), 0, "BGRA");
            Check.That(radius != Radius(Image.From(bgr, ColourFormat.Rgb8)), "the order of the colours says nothing");
            Check.Throws<ArgumentException>(() => Image.From(bgr, ColourFormat.Rgba8), "must be 4");
            Check.Throws<ArgumentException>(() => Image.From(bgra, 3, 4, ColourFormat.Bgra8, bgra.Length - 47), "elements");
        }

        private static double Radius(Image image)
        {
            using (Fitter fitter = Scene.Loaded())
            {
                fitter.PushImage(image);
                FitResult result = fitter.Fit();
                Check.Equal(result.LimbsLocated, fitter.Limbs().Count(limb => limb.Status == LimbStatus.Located));
                Check.That(result.LimbsLocated > 0, "no limb was located");
                Check.That(fitter.EndSamples().All(sample => sample.End < 2 && sample.Deviation > 0), "arcs");
                return result.Model.Radius;
            }
        }

        public static void OneInputIsForgotten()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                FitResult result = fitter.Fit();
                fitter.ClearInput(Inputs.Edges);
                Check.Equal(0L, fitter.Counts().SegmentsGiven);
                Check.Equal(result.PointsUsed, fitter.Counts().PointsUsed);
                Check.Near(result.Cost, fitter.Result().Cost, 0, "the last result stays");
                Check.Equal(0, fitter.Fit().SegmentsUsed);
                fitter.ClearInput(Inputs.Points | Inputs.Image);
                Check.Fails(Status.TooFewPoints, () => fitter.Fit());
                Check.Fails(Status.InvalidArgument, () => fitter.ClearInput((Inputs)1024), "1024");
            }
        }

        public static void ALabelSelectsPixels()
        {
            using (Fitter expected = Scene.Loaded())
            using (var fitter = new Fitter { Intrinsics = Scene.Camera })
            {
                byte[,] labels = Scene.Mask();
                for (int v = 0; v < Scene.Height; v++)
                    for (int u = 0; u < Scene.Width; u++) labels[v, u] = (byte)(labels[v, u] > 0 ? 3 : 1);
                Mask mask = Mask.From(labels);
                mask.Label = 3;
                fitter.PushDepth(DepthImage.From(Scene.Depth(), 1e-4), mask);
                Check.Equal(expected.Counts().PointsUsed, fitter.Counts().PointsUsed);
            }
        }

        public static void PlansAreExpected()
        {
            var camera = new Intrinsics(640, 480, 570, 570, 319.5, 239.5);
            var plan = new Plan { Distance = 0.7, Radius = 0.03, Length = 0.1, Tilt = 0.35, Turn = 0.42 };
            Expectation near = plan.Expect(camera);
            Check.That(near.Scatter.Radius > 0 && near.Scatter.Radius < near.Total.Radius, "radius");
            Check.That(near.Scatter.Length > 0 && near.Scatter.Length < near.Total.Length, "length");
            plan.Noise = new[] { 0.01, 0, 0, 9, 0.014, 0.7 };
            Check.That(plan.Expect(camera).Scatter.Position > 2 * near.Scatter.Position, "noise");
            plan.Noise = new double[1];
            Check.Throws<ArgumentException>(() => plan.Expect(camera), "must have 6");
            plan = new Plan { Distance = 0.7, Radius = 0.03, Length = 2 };
            Check.That(double.IsNaN(plan.Expect(camera).Total.Length), "a cut pipe");
        }

        public static void CamerasProjectAndUnproject()
        {
            var camera = new Intrinsics(640, 480, 500, 510, 320, 240, DistortionModel.BrownConrady, new[] { 0.1, -0.05 });
            var pixels = new double[,] { { 0, 0 }, { 320, 240 }, { 600.5, 20.25 } };
            double[,] rays = camera.Unproject(pixels);
            Check.Near(1, rays[2, 2], 0, "z");
            double[,] again = camera.Project(PointCloud.From(rays));
            for (int k = 0; k < 3; k++)
                for (int axis = 0; axis < 2; axis++) Check.Near(pixels[k, axis], again[k, axis], 1e-9, "pixel");
            Check.That(double.IsNaN(camera.Project(PointCloud.From(new double[,] { { 0, 0, -1 } }))[0, 0]), "behind");
            Check.Equal(0, camera.Unproject(new double[0, 2]).Length);
            Check.Throws<ArgumentException>(() => camera.Unproject(new double[2, 3]), "must be 2");
        }

        /// <summary>Calls that only read run side by side, and each thread reads the message of its own
        /// failure.</summary>
        public static void ManyThreadsReadAtOnce()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                FitResult result = fitter.Fit();
                double length = fitter.Extent().Length;
                Task[] readers = Enumerable.Range(1, 8).Select(reader => Task.Factory.StartNew(() =>
                {
                    var bad = new Cylinder(result.Model.Point, result.Model.Direction, -reader);
                    for (int round = 0; round < 20; round++)
                    {
                        Check.Near(result.Cost, fitter.Result().Cost, 0, "cost");
                        Check.Near(result.PointRms, fitter.Evaluate(result.Model).PointRms, 1e-12, "evaluated");
                        Check.Equal(result.PointsUsed, (long)fitter.Residuals(ResidualKind.Points).Length);
                        Check.Near(length, fitter.Extent().Length, 0, "length");
                        Check.Fails(Status.InvalidArgument, () => fitter.Evaluate(bad), "-" + reader);
                    }
                }, TaskCreationOptions.LongRunning)).ToArray();
                Task.WaitAll(readers);
            }
        }

        public static void ACallThatReadsIsBusyWhileAFitRuns()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                fitter.SetProgress(progress =>
                {
                    Task.Run(() => Check.Fails(Status.Busy, () => fitter.Result(), "busy")).Wait();
                    return true;
                });
                fitter.Fit();
            }
        }

        public static void TheIntervalDecidesAboutATolerance()
        {
            var tolerance = new Tolerance(19.5, 20.25);
            Check.Equal(Conformity.Conforming, tolerance.Decide(20.0, 0.12));
            Check.Equal(Conformity.Undecided, tolerance.Decide(20.0, 0.13));
            Check.Equal(Conformity.Conforming, new Tolerance(19.5, 20.25, 1.0).Decide(20.0, 0.13));
            Check.Equal(Conformity.NotConforming, tolerance.Decide(21.0, 0.3));
            Check.Equal(Conformity.Undecided, tolerance.Decide(20.0, double.NaN));
            Check.Equal(Conformity.Conforming, tolerance.Decide(20.0, 0.12, ResultFlags.WeakRadius));
            Check.Equal(Conformity.Undecided, tolerance.Decide(20.0, 0.12, ResultFlags.WeakRadius | ResultFlags.PoorFit));
            Check.Fails(Status.InvalidArgument, () => new Tolerance(21.0, 19.0).Decide(20.0, 0.1), "21 to 19");
        }

        public static void AResultIsJudgedAndAFitterCloned()
        {
            double[,] points = Scene.Pipe();
            for (int k = 0; k < 200; k++) points[k, 2] += 0.002 * Math.Sin(7 * k);
            var camera = new Intrinsics(640, 480, 570, 571, 319.5, 239.5);
            using (var fitter = new Fitter { Intrinsics = camera })
            {
                fitter.PushPoints(PointCloud.From(points));
                FitResult result = fitter.Fit();
                double radius = result.Model.Radius, deviation = result.RadiusDeviation;
                Check.That(deviation > 0 && deviation < 0.1 * radius, "deviation " + deviation);
                Check.Equal(Conformity.Conforming,
                    result.RadiusConforms(new Tolerance(radius - 2.1 * deviation, radius + 2.1 * deviation)));
                Check.Equal(Conformity.Undecided, result.RadiusConforms(new Tolerance(radius - 1.9 * deviation, 9.0)));
                Check.Equal(Conformity.Conforming,
                    result.DiameterConforms(new Tolerance(2 * radius - 4.2 * deviation, 2 * radius + 4.2 * deviation)));
                Check.Equal(Conformity.Undecided, result.DiameterConforms(new Tolerance(2 * radius - 3.8 * deviation, 9.0)));
                Check.Equal(Conformity.NotConforming, result.DiameterConforms(new Tolerance(0, radius)));

                fitter.SetProgress(progress => false);
                using (Fitter clone = fitter.Clone())
                {
                    Check.That(ReferenceEquals(camera, clone.Intrinsics), "camera");
                    Check.Near(radius, clone.Result().Model.Radius, 0, "result");
                    Check.Near(radius, clone.Fit().Model.Radius, 0, "fit without the callback");
                    clone.Clear();
                    Check.Equal(200L, fitter.Counts().PointsGiven);
                }
                fitter.Dispose();
                Check.Throws<ObjectDisposedException>(() => fitter.Clone(), "Fitter");
            }
        }
    }
}

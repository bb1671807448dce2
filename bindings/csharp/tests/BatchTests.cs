using System;
using System.Linq;

namespace Cylfuse.Tests
{
    [Tests]
    internal static class BatchTests
    {
        /// <summary>Pieces of a pipe; that of the third is a line.</summary>
        private static Fitter[] Fitters() => Enumerable.Range(0, 8).Select(k =>
        {
            var points = new double[200 + 10 * k, 3];
            for (int n = 0; n < points.GetLength(0); n++)
            {
                double angle = k == 2 ? 0 : 0.007 * n;
                points[n, 0] = 0.5 * Math.Cos(angle);
                points[n, 1] = 0.1 * (n % 7);
                points[n, 2] = 2 - 0.5 * Math.Sin(angle);
            }
            var fitter = new Fitter();
            fitter.PushPoints(PointCloud.From(points));
            return fitter;
        }).ToArray();

        public static void FitsAreThoseOfSingleCalls()
        {
            Fitter[] alone = Fitters();
            foreach (int threads in new[] { 0, 1, 3 })
            {
                Fitter[] fitters = Fitters();
                var heard = new bool[fitters.Length];
                CylfuseException[] failures = Fitter.FitAll(fitters, threads, (index, status) =>
                {
                    heard[index] = status == (index == 2 ? Status.CollinearPoints : Status.Ok);
                    return true;
                });
                Check.That(heard.All(was => was), "heard");
                for (int k = 0; k < fitters.Length; k++)
                {
                    if (k == 2)
                    {
                        Check.Equal(Status.CollinearPoints, failures[k].Status);
                        Check.That(failures[k] is UnusableDataException && failures[k].Message.Contains("line"), "text");
                    }
                    else
                    {
                        Check.That(failures[k] == null, "failure");
                        Check.Equal(alone[k].Fit().Model.Radius, fitters[k].Result().Model.Radius, "radius");
                    }
                    fitters[k].Dispose();
                }
            }
            foreach (Fitter fitter in alone) fitter.Dispose();
        }

        public static void TheRestCanBeStopped()
        {
            Fitter[] fitters = Fitters();
            CylfuseException[] failures = Fitter.FitAll(fitters, 1, (index, status) => index < 3);
            for (int k = 0; k < fitters.Length; k++)
            {
                Status expected = k == 2 ? Status.CollinearPoints : k < 4 ? Status.Ok : Status.Cancelled;
                Check.Equal(expected, failures[k]?.Status ?? Status.Ok, "status");
            }
            Check.That(failures[4].Message.Contains("cancel"), failures[4].Message);
            Check.That(fitters[3].Result().Model.Radius > 0, "fitted");
            Check.Fails(Status.BadState, () => fitters[4].Result());
            Check.Throws<InvalidOperationException>(
                () => Fitter.FitAll(fitters, 2, (index, status) => throw new InvalidOperationException("heard")), "heard");
            Check.Fails(Status.InvalidArgument, () => Fitter.FitAll(new[] { fitters[0], fitters[0] }));
            Check.Throws<ArgumentNullException>(() => Fitter.FitAll(new[] { fitters[0], null }), "fitters[1] is null");
            fitters[5].Dispose();
            Check.Throws<ObjectDisposedException>(() => Fitter.FitAll(fitters), "Fitter");
            Check.Equal(0, Fitter.FitAll(new Fitter[0]).Length);
            foreach (Fitter fitter in fitters) fitter.Dispose();
        }

        public static void ABusyFitterHasItsText()
        {
            Fitter[] fitters = Fitters().Take(2).ToArray();
            bool heard = false;
            fitters[0].SetProgress(progress =>
            {
                CylfuseException[] failures = Fitter.FitAll(fitters, 2);
                Check.Equal(Status.Busy, failures[0].Status);
                Check.That(failures[0].Message.Contains("the handle is busy in another call"), failures[0].Message);
                Check.That(failures[1] == null, "failure");
                return heard = true;
            });
            fitters[0].Fit();
            Check.That(heard, "heard");
            foreach (Fitter fitter in fitters) fitter.Dispose();
        }
    }
}

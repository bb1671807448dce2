using System;
using System.IO;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace Cylfuse.Tests
{
    [Tests]
    internal static class LifetimeTests
    {
        private const int Threads = 8;
        private const int Cycles = 10000;

        public static void AClosedFitterSaysSo()
        {
            var fitter = new Fitter();
            fitter.Dispose();
            fitter.Dispose();
            Check.Throws<ObjectDisposedException>(() => fitter.Fit(), "Fitter");
            Check.Throws<ObjectDisposedException>(() => fitter.Cancel(), "Fitter");
        }

        public static void DisposeInsideACallLeavesItsFailure()
        {
            Fitter fitter = Scene.Loaded();
            fitter.SetProgress(progress => { fitter.Dispose(); return false; });
            Check.Fails(Status.Cancelled, () => fitter.Fit(), "cancelled by the caller");
            Check.Throws<ObjectDisposedException>(() => fitter.Fit(), "Fitter");
        }

        public static void AnotherThreadCancelsAFit()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                var inside = new ManualResetEventSlim();
                var cancelled = new ManualResetEventSlim();
                fitter.SetProgress(progress => { inside.Set(); cancelled.Wait(); return true; });
                Task fit = Task.Factory.StartNew(() => Check.Fails(Status.Cancelled, () => fitter.Fit()),
                    TaskCreationOptions.LongRunning);
                inside.Wait();
                fitter.Cancel();
                cancelled.Set();
                fit.Wait();
            }
        }

        /// <summary>Points that come and go between asking for their number and for their residuals.</summary>
        public static void WhatIsListedIsOfOneMoment()
        {
            using (var fitter = new Fitter())
            {
                // At the distance 1 of the surface, each.
                var points = new double[50, 3];
                for (int k = 0; k < 50; k++) points[k, 0] = 1.5;
                PointCloud cloud = PointCloud.From(points);
                var along = new Cylinder(new Vector(0, 0, 0), new Vector(0, 0, 1), 0.5);
                bool ended = false;
                Task changing = Task.Factory.StartNew(() =>
                {
                    for (int k = 0; !Volatile.Read(ref ended); k++)
                        Free(() => { if (k % 8 == 0) fitter.Clear(); else fitter.PushPoints(cloud); });
                }, TaskCreationOptions.LongRunning);
                try
                {
                    for (int k = 0; k < 20000; k++)
                    {
                        Free(() => Check.That(fitter.Residuals(ResidualKind.Points, along).All(x => x == 1), "residuals"));
                        Free(() => Check.That(fitter.PointParts(along).All(part => part != 0), "parts"));
                    }
                }
                finally
                {
                    Volatile.Write(ref ended, true);
                    changing.Wait();
                }
            }
        }

        /// <summary>A call that the other thread may keep from being made.</summary>
        private static void Free(Action call)
        {
            try { call(); }
            catch (CylfuseException failure) when (failure.Status == Status.Busy) { }
        }

        /// <summary>The abortion must not jump over the frames of the library.</summary>
        public static void AnAbortedThreadLeavesTheFitterUsable()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                var inside = new ManualResetEventSlim();
                fitter.SetProgress(progress => { inside.Set(); Thread.Sleep(Timeout.Infinite); return true; });
                Exception seen = null;
                var thread = new Thread(() =>
                {
                    try { fitter.Fit(); }
                    catch (ThreadAbortException failure) { seen = failure; Thread.ResetAbort(); }
                });
                thread.Start();
                inside.Wait();
                thread.Abort();
                thread.Join();
                Check.That(seen != null, "the abortion did not come out of the fit");
                fitter.SetProgress(null);
                Check.Near(Scene.Truth.Radius, fitter.Fit().Model.Radius, 1e-3, "radius");
            }
        }

        public static void DisposeInsideACallWaitsForIt()
        {
            Fitter fitter = Scene.Loaded();
            fitter.SetProgress(progress => { fitter.Dispose(); return true; });
            Check.Near(Scene.Truth.Radius, fitter.Fit().Model.Radius, 1e-3, "radius");
            Check.Throws<ObjectDisposedException>(() => fitter.Fit(), "");
        }

        /// <summary>A leak of one fitter with its data a cycle would be 10,000 times 5 kB.</summary>
        public static void TenThousandCyclesLeaveMemoryFlat()
        {
            Cycle(Cycles / 5, true);
            MemoryStaysFlat(16, () => Cycle(Cycles, true));
        }

        public static void TheGarbageCollectorFreesWhatWasNotDisposed()
        {
            Cycle(Cycles / 5, false);
            MemoryStaysFlat(16, () => Cycle(Cycles, false));
        }

        private static void Cycle(int count, bool dispose)
        {
            double[,] points = Scene.Pipe(50);
            var options = new FitOptions { MaxThreads = 1, Start = StartKind.Moments };
            for (int k = 0; k < count; k++)
            {
                var fitter = new Fitter { Options = options };
                // Callbacks that know their fitter do not keep it alive.
                fitter.SetProgress(progress => fitter != null);
                fitter.SetLog(LogLevel.Debug, (level, line) => fitter.GetHashCode());
                fitter.PushPoints(PointCloud.From(points));
                fitter.Fit();
                if (dispose) fitter.Dispose();
                // The collector does not know how large a fitter is; a program that never disposes needs its runs.
                else if (k % 500 == 0) { GC.Collect(); GC.WaitForPendingFinalizers(); }
            }
            GC.Collect();
            GC.WaitForPendingFinalizers();
        }

        /// <summary>A leak of one frame a cycle would be 1,000 times 100 kB.</summary>
        public static void FramesAreFreedWithTheirFitters()
        {
            CycleFrames(200);
            MemoryStaysFlat(16, () => CycleFrames(1000));
        }

        private static void CycleFrames(int count)
        {
            DepthImage depth = DepthImage.From(Scene.Depth(), 1e-4);
            Image image = Image.From(Scene.Grey());
            for (int k = 0; k < count; k++)
            {
                using (var fitter = new Fitter())
                using (var frame = new Frame { Intrinsics = Scene.Camera })
                {
                    frame.SetDepth(depth);
                    frame.SetImage(image);
                    fitter.UseFrame(frame);
                }
            }
            GC.Collect();
            GC.WaitForPendingFinalizers();
        }

        /// <summary>A leak shows every time, what a collector is late with does not.</summary>
        internal static void MemoryStaysFlat(int megabytes, Action use)
        {
            long growth = 0;
            for (int round = 0; round < 3; round++)
            {
                long before = ResidentKilobytes();
                use();
                growth = ResidentKilobytes() - before;
                if (growth < megabytes * 1024) return;
            }
            Check.That(false, $"memory grew by {growth} kB");
        }

        private static long ResidentKilobytes() => File.ReadLines("/proc/self/status")
            .Where(line => line.StartsWith("VmRSS:"))
            .Select(line => long.Parse(line.Split(new[] { ' ', '\t' },
                StringSplitOptions.RemoveEmptyEntries)[1])).Single();

        public static void EightThreadsOnTheirOwnFittersAgree()
        {
            FitResult[] results = Enumerable.Range(0, Threads).Select(k => Task.Factory.StartNew(() =>
            {
                FitResult last = null;
                using (Fitter fitter = Scene.Loaded())
                    for (int round = 0; round < 20; round++) last = fitter.Fit();
                return last;
            }, TaskCreationOptions.LongRunning)).Select(task => task.Result).ToArray();
            foreach (FitResult result in results)
            {
                Check.Near(results[0].Model.Radius, result.Model.Radius, 0, "radius");
                Check.Near(results[0].Cost, result.Cost, 0, "cost");
            }
        }

        public static void OneFitterInTwoThreadsThrowsAndNeverCrashes()
        {
            using (Fitter fitter = Scene.Loaded())
            {
                // A fit that stays inside its callback until the other thread has tried.
                var inside = new ManualResetEventSlim();
                var tried = new ManualResetEventSlim();
                fitter.SetProgress(progress => { inside.Set(); tried.Wait(); return true; });
                Task<FitResult> fit = Task.Factory.StartNew(() => fitter.Fit(), TaskCreationOptions.LongRunning);
                inside.Wait();
                Check.Fails(Status.Busy, () => fitter.Counts(), "busy");
                Check.Fails(Status.Busy, () => fitter.Fit(), "busy");
                tried.Set();
                Check.Near(Scene.Truth.Radius, fit.Result.Model.Radius, 1e-3, "radius");
            }
            for (int round = 0; round < 20; round++)
            {
                Fitter fitter = Scene.Loaded();
                Task[] tasks = Enumerable.Range(0, Threads).Select(k => Task.Factory.StartNew(() =>
                {
                    for (int call = 0; call < 50; call++)
                    {
                        try
                        {
                            if (k == 0 && call == 25) fitter.Dispose();
                            if (call % 2 == 0) fitter.Fit(); else fitter.Residuals(ResidualKind.Points);
                        }
                        catch (CylfuseException failure) when (failure.Status == Status.Busy
                            || failure.Status == Status.BadState) { }
                        catch (ObjectDisposedException) { }
                    }
                }, TaskCreationOptions.LongRunning)).ToArray();
                Task.WaitAll(tasks);
            }
        }
    }
}

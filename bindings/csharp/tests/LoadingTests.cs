using System;
using System.Diagnostics;
using System.Linq;

namespace Cylfuse.Tests
{
    /// <summary>What happens when the native library is missing or another one. Each case is a process of its own,
    /// because a process opens the library once.</summary>
    [Tests]
    internal static class LoadingTests
    {
        public static void AMissingLibraryIsNamed() =>
            Expect("/nowhere/libcylfuse.so", nameof(DllNotFoundException), "CYLFUSE_LIBRARY names this file",
                "/nowhere/libcylfuse.so: cannot open shared object file");

        public static void WithoutTheVariableThePlacesAreNamed() =>
            Expect("", nameof(DllNotFoundException), "in the environment variable CYLFUSE_LIBRARY", "/native/libcylfuse.so: ",
                "\n  libcylfuse.so: ");

        public static void WhatIsNoLibraryIsRefused() =>
            Expect("/dev/null", nameof(DllNotFoundException), "/dev/null: ");

        public static void AnotherLibraryIsRefused() =>
            Expect("libm.so.6", nameof(EntryPointNotFoundException),
                "libm.so.6 has no function cylfuse_abi_version", "older than this package");

        /// <summary>test.sh makes a library that says this of itself.</summary>
        public static void AnotherBinaryInterfaceIsRefused() =>
            Expect(Environment.GetEnvironmentVariable("CYLFUSE_OTHER_ABI"), nameof(CylfuseException),
                "has version 2 of the binary interface; this package needs version 1");

        /// <summary>In the other process: tries twice, because the second time must say the same.</summary>
        internal static int Open()
        {
            var attempts = new Action[] { () => new Fitter().Dispose(), () => new FitOptions() };
            foreach (Action attempt in attempts)
            {
                try { attempt(); }
                catch (Exception failure) { Console.WriteLine($"{failure.GetType().Name}: {failure.Message}"); }
            }
            return 0;
        }

        private static void Expect(string library, string exception, params string[] parts)
        {
            string printed = Run(library, nameof(Open));
            string[] attempts = printed.Split(new[] { exception + ": " }, StringSplitOptions.None);
            Check.Equal(3, attempts.Length, printed);
            Check.Equal(attempts[1], attempts[2], "the second attempt");
            Check.That(parts.All(part => attempts[1].Contains(part)), printed);
        }

        /// <summary>Runs this program with another library; gives what it printed.</summary>
        internal static string Run(string library, string what)
        {
            var start = new ProcessStartInfo("mono", $"\"{typeof(LoadingTests).Assembly.Location}\" {what}")
            {
                UseShellExecute = false, RedirectStandardOutput = true,
            };
            start.EnvironmentVariables["CYLFUSE_LIBRARY"] = library;
            using (Process process = Process.Start(start))
            {
                string printed = process.StandardOutput.ReadToEnd();
                process.WaitForExit();
                return printed;
            }
        }
    }
}

using System;
using System.Collections.Generic;
using System.IO;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>Finds and opens the native library.</summary>
    /// <remarks>In this order: the file named by the environment variable CYLFUSE_LIBRARY and no other; the package's
    /// runtimes/RID/native folder and the folder of this assembly; the places where the system looks.</remarks>
    internal static class NativeLibraryFile
    {
        private const int ResolveNow = 2; // RTLD_NOW, the same on Linux and macOS

        private static bool Windows => RuntimeInformation.IsOSPlatform(OSPlatform.Windows);
        private static bool MacOs => RuntimeInformation.IsOSPlatform(OSPlatform.OSX);

        internal static IntPtr Open()
        {
            // The structs are laid out for pointers of 8 bytes.
            if (IntPtr.Size != 8)
                throw new PlatformNotSupportedException($"cylfuse needs a 64-bit process; this one has {8 * IntPtr.Size} bits.");
            string given = Environment.GetEnvironmentVariable("CYLFUSE_LIBRARY");
            var candidates = string.IsNullOrEmpty(given) ? Candidates() : new List<string> { given };
            foreach (string file in candidates)
            {
                // A path that does not exist is skipped, so that a file that does exist and fails to load is heard of.
                if (Path.IsPathRooted(file) && !File.Exists(file)) continue;
                IntPtr library = Windows ? LoadLibraryW(file)
                    : MacOs ? dlopenOnMac(file, ResolveNow) : dlopen(file, ResolveNow);
                if (library != IntPtr.Zero) return library;
            }
            throw new DllNotFoundException(
                $"The native library of cylfuse was not found; tried {string.Join(", ", candidates)}. " +
                "Name its file in the environment variable CYLFUSE_LIBRARY.");
        }

        internal static IntPtr Find(IntPtr library, string name)
        {
            IntPtr function = Windows ? GetProcAddress(library, name)
                : MacOs ? dlsymOnMac(library, name) : dlsym(library, name);
            if (function == IntPtr.Zero)
                throw new EntryPointNotFoundException($"The native library of cylfuse has no function {name}: it is older than this package.");
            return function;
        }

        private static List<string> Candidates()
        {
            string name = Windows ? "cylfuse.dll" : MacOs ? "libcylfuse.dylib" : "libcylfuse.so";
            string system = Windows ? "win" : MacOs ? "osx" : "linux";
            string processor = RuntimeInformation.ProcessArchitecture.ToString().ToLowerInvariant();
            var candidates = new List<string>();
            string assembly = typeof(NativeLibraryFile).Assembly.Location;
            foreach (string folder in new[] { Path.GetDirectoryName(assembly), AppContext.BaseDirectory })
            {
                if (string.IsNullOrEmpty(folder)) continue;
                candidates.Add(Path.Combine(folder, "runtimes", system + "-" + processor, "native", name));
                candidates.Add(Path.Combine(folder, name));
            }
            candidates.Add(name);
            return candidates;
        }

        [DllImport("libdl.so.2")]
        private static extern IntPtr dlopen(string file, int flags);

        [DllImport("libdl.so.2")]
        private static extern IntPtr dlsym(IntPtr library, string name);

        [DllImport("libSystem.dylib", EntryPoint = "dlopen")]
        private static extern IntPtr dlopenOnMac(string file, int flags);

        [DllImport("libSystem.dylib", EntryPoint = "dlsym")]
        private static extern IntPtr dlsymOnMac(IntPtr library, string name);

        [DllImport("kernel32", CharSet = CharSet.Unicode)]
        private static extern IntPtr LoadLibraryW(string file);

        [DllImport("kernel32", CharSet = CharSet.Ansi)]
        private static extern IntPtr GetProcAddress(IntPtr library, string name);
    }
}

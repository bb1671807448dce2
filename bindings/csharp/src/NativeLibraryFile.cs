using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>Finds and opens the native library.</summary>
    /// <remarks>In this order: the file named by the environment variable CYLFUSE_LIBRARY and no other; the package's
    /// runtimes/RID/native folder and the folder of this assembly; the places where the system looks.</remarks>
    internal static class NativeLibraryFile
    {
        private const int ResolveNow = 2; // RTLD_NOW, the same on Linux and macOS

        private static IntPtr library;

        private static bool Windows => RuntimeInformation.IsOSPlatform(OSPlatform.Windows);
        private static bool MacOs => RuntimeInformation.IsOSPlatform(OSPlatform.OSX);

        /// <summary>The file that was opened, or the name that the system found.</summary>
        internal static string Opened { get; private set; }

        internal static void Open()
        {
            // The structs are laid out for pointers of 8 bytes.
            if (IntPtr.Size != 8)
                throw new PlatformNotSupportedException($"cylfuse needs a 64-bit process; this one has {8 * IntPtr.Size} bits.");
            string given = Environment.GetEnvironmentVariable("CYLFUSE_LIBRARY");
            bool named = !string.IsNullOrEmpty(given);
            string tried = "";
            foreach (string file in named ? new[] { given } : Candidates())
            {
                library = Load(file, out string failure);
                Opened = file;
                if (library != IntPtr.Zero) return;
                tried += "\n  " + failure;
            }
            throw new DllNotFoundException("The native library of cylfuse cannot be opened. " + (named
                ? "The environment variable CYLFUSE_LIBRARY names this file; correct or remove it:"
                : "Name its file in the environment variable CYLFUSE_LIBRARY, or put it into one of these places:") + tried);
        }

        internal static IntPtr Find(string name)
        {
            IntPtr function = Windows ? GetProcAddress(library, name)
                : MacOs ? dlsymOnMac(library, name) : dlsym(library, name);
            if (function == IntPtr.Zero)
                throw new EntryPointNotFoundException(
                    $"{Opened} has no function {name}: it is not the native library of cylfuse, or older than this package.");
            return function;
        }

        private static IntPtr Load(string file, out string failure)
        {
            if (Windows)
            {
                IntPtr module = LoadLibraryW(file);
                failure = $"{file}: error {Marshal.GetLastWin32Error()} of the system";
                return module;
            }
            // The message begins with the name of the file. Called once before, because the runtime's own search for dlerror would clear the message.
            Marshal.PtrToStringAnsi(MacOs ? dlerrorOnMac() : dlerror());
            IntPtr opened = MacOs ? dlopenOnMac(file, ResolveNow) : dlopen(file, ResolveNow);
            failure = opened != IntPtr.Zero ? null : Marshal.PtrToStringAnsi(MacOs ? dlerrorOnMac() : dlerror());
            return opened;
        }

        private static IEnumerable<string> Candidates()
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
            return candidates.Distinct();
        }

        [DllImport("libdl.so.2")]
        private static extern IntPtr dlopen(string file, int flags);

        [DllImport("libdl.so.2")]
        private static extern IntPtr dlsym(IntPtr library, string name);

        [DllImport("libdl.so.2")]
        private static extern IntPtr dlerror();

        [DllImport("libSystem.dylib", EntryPoint = "dlopen")]
        private static extern IntPtr dlopenOnMac(string file, int flags);

        [DllImport("libSystem.dylib", EntryPoint = "dlsym")]
        private static extern IntPtr dlsymOnMac(IntPtr library, string name);

        [DllImport("libSystem.dylib", EntryPoint = "dlerror")]
        private static extern IntPtr dlerrorOnMac();

        [DllImport("kernel32", CharSet = CharSet.Unicode, SetLastError = true)]
        private static extern IntPtr LoadLibraryW(string file);

        [DllImport("kernel32", CharSet = CharSet.Ansi)]
        private static extern IntPtr GetProcAddress(IntPtr library, string name);
    }
}

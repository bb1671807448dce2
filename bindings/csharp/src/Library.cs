using System;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>Facts about the loaded native library.</summary>
    public static class Library
    {
        /// <summary>The version of the binary interface.</summary>
        public static int AbiVersion => (int)Native.Functions.AbiVersion();

        /// <summary>The version as text, such as "0.2.0".</summary>
        public static string VersionString => Text(Native.Functions.VersionString());

        /// <summary>The version as a number: major * 65536 + minor * 256 + patch.</summary>
        public static int VersionNumber => (int)Native.Functions.VersionNumber();

        /// <summary>How the library was built: version, target, profile, compiler, features; for reports of
        /// defects.</summary>
        public static string BuildInfo => Text(Native.Functions.BuildInfo());

        /// <summary>The name of a status, a colon, and what it means in a few words.</summary>
        public static string StatusText(Status status) => Text(Native.Functions.StatusString((int)status));

        // The texts of the library are ASCII.
        internal static string Text(IntPtr text) => Marshal.PtrToStringAnsi(text);
    }
}

using System;

namespace Cylfuse
{
    /// <summary>The opened library, and what the conversions from and to its structs share.</summary>
    internal static class Native
    {
        internal const int DepthFormatU16 = 1;
        internal const int DepthFormatF32 = 2;
        internal const int ImageFormatU8 = 1;
        internal const int ImageFormatU16 = 2;
        internal const int ImageFormatF32 = 3;
        internal const int ScalarF32 = 1;
        internal const int ScalarF64 = 2;

        // Lazy, because what fails in a static constructor comes out wrapped, without its message.
        private static readonly Lazy<NativeFunctions> functions = new Lazy<NativeFunctions>(NativeFunctions.Open);

        /// <summary>The functions of the library, which the first use opens.</summary>
        /// <exception cref="DllNotFoundException">The library was not found or cannot be loaded.</exception>
        /// <exception cref="EntryPointNotFoundException">The library lacks a function.</exception>
        /// <exception cref="CylfuseException">The library has another binary interface (AbiMismatch).</exception>
        internal static NativeFunctions Functions => functions.Value;

        /// <summary>Throws for a failed call without a handle.</summary>
        internal static void Check(int status)
        {
            if (status != 0) throw Failure(status, Functions.FitterLastError(IntPtr.Zero));
        }

        /// <summary>The exception for a failed call, with its message.</summary>
        internal static CylfuseException Failure(int status, IntPtr message) =>
            CylfuseException.For((Status)status, Library.Text(message));

        internal static unsafe double[] Copy(double* numbers, int count)
        {
            var copy = new double[count];
            for (int k = 0; k < count; k++) copy[k] = numbers[k];
            return copy;
        }

        internal static unsafe double[,] Square(double* numbers, int size)
        {
            var square = new double[size, size];
            for (int row = 0; row < size; row++)
                for (int column = 0; column < size; column++)
                    square[row, column] = numbers[size * row + column];
            return square;
        }
    }
}

using System;

namespace Cylfuse
{
    /// <summary>What the conversions from and to native structs share.</summary>
    internal static class Native
    {
        internal const int DepthFormatU16 = 1;
        internal const int DepthFormatF32 = 2;
        internal const int ImageFormatU8 = 1;
        internal const int ImageFormatU16 = 2;
        internal const int ImageFormatF32 = 3;
        internal const int ScalarF32 = 1;
        internal const int ScalarF64 = 2;

        internal static int Scalar(Type type) => type == typeof(float) ? ScalarF32 : ScalarF64;

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

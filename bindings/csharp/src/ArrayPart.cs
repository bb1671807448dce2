using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>The elements of an array that a view takes: a grid of items of a few neighbouring elements each, of
    /// which every one is checked to lie inside the array. The array is not copied.</summary>
    internal sealed class ArrayPart
    {
        private readonly Array array;
        private readonly int offset;

        /// <summary>Columns of the grid.</summary>
        internal int Width { get; }

        /// <summary>Rows of the grid.</summary>
        internal int Height { get; }

        /// <summary>Bytes from an item to the next one in its row; 0 = packed.</summary>
        internal IntPtr ItemStride { get; }

        /// <summary>Bytes from a row to the next one; 0 = packed.</summary>
        internal IntPtr RowStride { get; }

        /// <summary>Bytes of an element. They tell the type, of which a short[] may pass for a ushort[].</summary>
        internal int ElementSize { get; }

        /// <param name="what">The name of the items in messages, in the plural.</param>
        /// <param name="array">An array of primitive elements, of any rank.</param>
        /// <param name="components">Elements of an item.</param>
        /// <param name="width">Items of a row.</param>
        /// <param name="height">Rows.</param>
        /// <param name="offset">Index of the first element of the first item.</param>
        /// <param name="itemStride">Elements from an item to the next one; 0 = components.</param>
        /// <param name="rowStride">Elements from a row to the next one; 0 = width * itemStride.</param>
        internal ArrayPart(string what, Array array, int components, int width, int height,
            int offset = 0, int itemStride = 0, int rowStride = 0)
        {
            if (array == null) throw new ArgumentNullException(nameof(array), $"The array of the {what} is null.");
            if (width < 0 || height < 0)
                throw new ArgumentException($"{width} x {height} {what} cannot be: neither number may be negative.");
            this.array = array;
            this.offset = offset;
            Width = width;
            Height = height;
            ElementSize = SizeOf(array.GetType().GetElementType());
            ItemStride = (IntPtr)((long)itemStride * ElementSize);
            RowStride = (IntPtr)((long)rowStride * ElementSize);
            if (width == 0 || height == 0) return;

            long item = itemStride == 0 ? components : itemStride;
            long row = rowStride == 0 ? width * item : rowStride;
            // Decimals hold the product of three integers.
            decimal alongRow = (width - 1) * (decimal)item;
            decimal alongColumn = (height - 1) * (decimal)row;
            decimal first = offset + Math.Min(alongRow, 0) + Math.Min(alongColumn, 0);
            decimal last = offset + Math.Max(alongRow, 0) + Math.Max(alongColumn, 0) + components - 1;
            if (first < 0 || last >= array.Length)
                throw new ArgumentException(
                    $"{width} x {height} {what} need the elements {first} to {last} of an array that has {array.Length}: " +
                    "check its length, the width and height, the offset and the strides.");
        }

        /// <summary>Checks that a second dimension is what it must be.</summary>
        internal static void RequireColumns(string what, int columns, int needed)
        {
            if (columns != needed)
                throw new ArgumentException($"The last dimension of the {what} is {columns}; it must be {needed}.");
        }

        private static int SizeOf(Type element)
        {
            switch (Type.GetTypeCode(element))
            {
                case TypeCode.Double: return 8;
                case TypeCode.Single: return 4;
                case TypeCode.Int16:
                case TypeCode.UInt16: return 2;
                default: return 1;
            }
        }

        /// <summary>The address of the first item, valid until the pins are gone.</summary>
        internal IntPtr Pin(Pins pins) => (IntPtr)(pins.Add(array).ToInt64() + (long)offset * ElementSize);
    }

    /// <summary>Arrays that the garbage collector leaves in their places.</summary>
    internal sealed class Pins : IDisposable
    {
        private readonly List<GCHandle> handles = new List<GCHandle>(4);

        internal IntPtr Add(Array array)
        {
            GCHandle handle = GCHandle.Alloc(array, GCHandleType.Pinned);
            handles.Add(handle);
            return handle.AddrOfPinnedObject();
        }

        public void Dispose()
        {
            foreach (GCHandle handle in handles) handle.Free();
            handles.Clear();
        }
    }
}

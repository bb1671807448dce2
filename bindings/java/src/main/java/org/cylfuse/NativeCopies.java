package org.cylfuse;

import com.sun.jna.Memory;
import com.sun.jna.Pointer;
import java.lang.ref.Reference;
import java.nio.Buffer;
import java.util.ArrayList;
import java.util.List;

/** Native memory and direct buffers that a call reads or writes: freed, or let go, at the end of the call. */
final class NativeCopies implements AutoCloseable {
    private final List<Memory> memories = new ArrayList<>(4);
    private final List<Buffer> buffers = new ArrayList<>(4);

    /** Memory of a number of bytes, of one at least. */
    Memory allocate(long bytes) {
        Memory memory = new Memory(Math.max(bytes, 1));
        memories.add(memory);
        return memory;
    }

    /** Keeps a direct buffer alive until the end of the call. */
    Pointer keep(Buffer buffer, Pointer address) {
        buffers.add(buffer);
        return address;
    }

    @Override
    public void close() {
        memories.forEach(Memory::close);
        Reference.reachabilityFence(buffers);
    }
}

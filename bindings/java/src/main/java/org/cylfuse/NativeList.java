package org.cylfuse;

import com.sun.jna.Memory;
import com.sun.jna.Pointer;
import com.sun.jna.Structure;
import com.sun.jna.ptr.LongByReference;
import java.util.ArrayList;
import java.util.List;
import java.util.function.Function;

/** Arrays of structs that a call writes. */
final class NativeList {
    private NativeList() {}

    /** A call that writes an array. */
    interface Call {
        int apply(Pointer object, Pointer out, long elementSize, long capacity, LongByReference count);
    }

    /** A call that writes into what is made for a number of elements. */
    interface Filling {
        int apply(Pointer object, int capacity, LongByReference count);
    }

    /**
     * Asks for the number of elements and then for the elements, again where another thread has added some meanwhile.
     *
     * @return how many there are, which may have become fewer
     */
    static int fill(NativeHandle handle, Filling call) {
        LongByReference count = new LongByReference();
        handle.run(object -> {
            int status = call.apply(object, 0, count);
            while (status == Status.BUFFER_TOO_SMALL.value()) {
                status = call.apply(object, Math.toIntExact(count.getValue()), count);
            }
            return status;
        });
        return Math.toIntExact(count.getValue());
    }

    /** Lists structs. */
    static <S extends Structure, T> List<T> read(
            NativeHandle handle, Call call, Function<Pointer, S> struct, Function<S, T> convert) {
        long size = struct.apply(Pointer.NULL).size();
        List<T> elements = new ArrayList<>();
        fill(handle, (object, capacity, count) -> {
            try (Memory memory = new Memory(Math.max(size * capacity, 1))) {
                int status = call.apply(object, memory, size, capacity, count);
                for (long k = 0; k < count.getValue() && status == Status.OK.value(); k++) {
                    S element = struct.apply(memory.share(size * k));
                    element.read();
                    elements.add(convert.apply(element));
                }
                return status;
            }
        });
        return elements;
    }
}

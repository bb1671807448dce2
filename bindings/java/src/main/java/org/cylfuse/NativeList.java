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

    /** Asks for the number of elements and then for the elements. */
    static <S extends Structure, T> List<T> read(
            NativeHandle handle, Call call, Function<Pointer, S> struct, Function<S, T> convert) {
        long size = struct.apply(Pointer.NULL).size();
        List<T> elements = new ArrayList<>();
        handle.run(object -> {
            LongByReference count = new LongByReference();
            int status = call.apply(object, Pointer.NULL, size, 0, count);
            if (status != Status.BUFFER_TOO_SMALL.value() && status != Status.OK.value()) {
                return status;
            }
            try (Memory memory = new Memory(Math.max(size * count.getValue(), 1))) {
                status = call.apply(object, memory, size, count.getValue(), count);
                for (long k = 0; k < count.getValue() && status == Status.OK.value(); k++) {
                    S element = struct.apply(memory.share(size * k));
                    element.read();
                    elements.add(convert.apply(element));
                }
            }
            return status;
        });
        return elements;
    }
}

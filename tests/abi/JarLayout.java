package org.cylfuse;

import com.sun.jna.Structure;
import java.lang.reflect.Method;
import java.util.Arrays;
import java.util.Comparator;

/** Prints the structs of the JAR as JNA lays them out, with size, and their fields, with offset and size. */
final class JarLayout {
    public static void main(String[] arguments) throws ReflectiveOperationException {
        // JNA protects the offsets.
        Method offset = Structure.class.getDeclaredMethod("fieldOffset", String.class);
        offset.setAccessible(true);
        Class<?>[] kinds = NativeStructs.class.getDeclaredClasses();
        Arrays.sort(kinds, Comparator.comparing(Class::getSimpleName));
        for (Class<?> kind : kinds) {
            if (!Structure.class.isAssignableFrom(kind)) {
                continue;
            }
            Structure struct = (Structure) kind.getDeclaredConstructor().newInstance();
            String name = kind.getSimpleName().replaceAll("(?<!^)([A-Z])", "_$1").toLowerCase();
            System.out.println("cylfuse_" + name + " " + struct.size());
            String[] fields = kind.getAnnotation(Structure.FieldOrder.class).value();
            int[] offsets = new int[fields.length + 1];
            for (int k = 0; k < fields.length; k++) {
                offsets[k] = (int) offset.invoke(struct, fields[k]);
            }
            offsets[fields.length] = struct.size();
            for (int k = 0; k < fields.length; k++) {
                System.out.println("    " + fields[k] + " " + offsets[k] + " " + (offsets[k + 1] - offsets[k]));
            }
        }
    }
}

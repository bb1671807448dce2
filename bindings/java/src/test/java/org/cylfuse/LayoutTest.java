package org.cylfuse;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertFalse;

import com.sun.jna.Structure;
import java.io.IOException;
import java.lang.reflect.Modifier;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.List;
import java.util.Set;
import java.util.stream.Collectors;
import org.junit.Test;

/** The binding against the lists of the library in tests/data. */
public class LayoutTest {
    private static List<String> lines(String file) throws IOException {
        String repository = System.getenv("CYLFUSE_REPOSITORY");
        if (repository == null) {
            throw new IllegalStateException("CYLFUSE_REPOSITORY is not set: run test.sh");
        }
        List<String> lines = Files.readAllLines(Path.of(repository, "tests", "data", file));
        assertFalse(lines.isEmpty());
        return lines;
    }

    /** Gives away the offsets, which JNA protects. */
    private static int offset(Structure structure, String field) throws ReflectiveOperationException {
        java.lang.reflect.Method method = Structure.class.getDeclaredMethod("fieldOffset", String.class);
        method.setAccessible(true);
        return (int) method.invoke(structure, field);
    }

    @Test
    public void structsHaveTheLayoutOfTheLibrary() throws Exception {
        Structure structure = null;
        for (String line : lines("abi_layout.txt")) {
            String[] words = line.trim().split(" ");
            int number = Integer.parseInt(words[1]);
            if (line.startsWith(" ")) {
                assertEquals(line, number, offset(structure, words[0]));
            } else {
                String name = Arrays.stream(words[0].substring("cylfuse_".length()).split("_"))
                        .map(word -> Character.toUpperCase(word.charAt(0)) + word.substring(1))
                        .collect(Collectors.joining());
                structure = (Structure) Class.forName("org.cylfuse.NativeStructs$" + name).getDeclaredConstructor().newInstance();
                assertEquals(line, number, structure.size());
            }
        }
    }

    @Test
    public void statusesHaveTheNumbersOfTheLibrary() throws IOException {
        List<String> known = Arrays.stream(Status.values())
                .filter(status -> status != Status.UNKNOWN)
                .map(status -> status.value() + " " + status)
                .toList();
        assertEquals(lines("status_codes.txt"), known);
    }

    @Test
    public void everyFunctionOfTheHeaderIsBound() throws IOException {
        Set<String> bound = Arrays.stream(NativeFunctions.class.getDeclaredMethods())
                .filter(method -> Modifier.isNative(method.getModifiers()))
                .map(java.lang.reflect.Method::getName)
                .collect(Collectors.toSet());
        assertEquals(Set.copyOf(lines("symbols.txt")), bound);
    }
}

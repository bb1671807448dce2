#!/usr/bin/env bash
# What is there for C and C++: installation, packages, headers, examples, tests against OpenCV and PCL, reference.
# Ends with the number of checks. PCL and OpenCV come from Debian: tests/packages.sh.
set -uo pipefail
# Messages and numbers of tools as they are read here.
export LC_ALL=C.UTF-8
cd "$(dirname "$0")/.."
source packaging/debian.sh
root=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
jobs=$(nproc)
passed=0 failed=0
# The library of the tests of Rust where that is there; the program is no part of it.
make=(make --no-print-directory PROFILE=release)

# check NAME COMMAND...: counts whether the command succeeds, and shows what it printed when it does not.
check() {
    local name=$1 start=$SECONDS
    shift
    if "$@" > "$work/log" 2>&1; then
        passed=$((passed + 1))
        printf 'ok      %s (%s s)\n' "$name" $((SECONDS - start))
    else
        failed=$((failed + 1))
        printf 'FAILED  %s\n' "$name"
        tail -n 60 "$work/log" | sed 's/^/        /'
    fi
}
not() { ! "$@"; }
prints() { # prints REGEX COMMAND...: the command succeeds and prints this.
    local regex=$1 output
    shift
    output=$("$@" 2>&1) || { printf '%s\n' "$output"; return 1; }
    grep -Eq "$regex" <<< "$output" || { printf 'no "%s" in:\n%s\n' "$regex" "$output"; return 1; }
}
# block FILE LANGUAGE NUMBER: a block of code of a document.
block() { awk -v open="\`\`\`$2" -v number="$3" '$0 == open { count++; inside = 1; next } /^```$/ { inside = 0 } inside && count == number' "$1"; }

printf '\n-- installation\n'
prefix=$work/first
check "make install" "${make[@]}" install PREFIX="$prefix"
listing=$(cd "$prefix" && find . \( -type f -o -type l \) | sort | tr '\n' ' ')
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
soname=$(readelf -d "$prefix/lib/libcylfuse.so" | sed -n 's/.*soname: \[\(.*\)\]/\1/p')
check "what was installed" test "$listing" = "./include/cylfuse/batch.hpp ./include/cylfuse/callbacks.hpp ./include/cylfuse/cylfuse.h \
./include/cylfuse/cylfuse.hpp ./include/cylfuse/cylinder.hpp ./include/cylfuse/detector.hpp ./include/cylfuse/eigen.hpp ./include/cylfuse/enums.hpp \
./include/cylfuse/error.hpp ./include/cylfuse/frame.hpp ./include/cylfuse/handle.hpp ./include/cylfuse/names.hpp ./include/cylfuse/opencv.hpp ./include/cylfuse/pcl.hpp \
./include/cylfuse/pcl_detection.hpp ./include/cylfuse/pcl_segmentation.hpp ./include/cylfuse/types.hpp ./include/cylfuse/views.hpp \
./lib/cmake/cylfuse/cylfuse-config-version.cmake ./lib/cmake/cylfuse/cylfuse-config.cmake ./lib/libcylfuse.a \
./lib/libcylfuse.so ./lib/$soname ./lib/libcylfuse.so.$version ./lib/pkgconfig/cylfuse.pc "
uninstalls() { # uninstalls: a copy of the installation, named as other projects name it
    cp -a "$prefix" "$work/copy" && "${make[@]}" uninstall prefix="$work/copy" && test -z "$(find "$work/copy" -type f -o -type l)"
}
check "make uninstall" uninstalls
refuses_spaces() { # refuses_spaces: `rm` would take the rest of such a path for another one
    local name
    mkdir -p "$work/a b/lib" "$work/a/include/cylfuse"
    touch "$work/a b/lib/libcylfuse.so" "$work/a/include/cylfuse/kept"
    for name in PREFIX prefix LIBDIR INCLUDEDIR DESTDIR; do
        for goal in install uninstall; do
            ! "${make[@]}" "$goal" "$name=$work/a b" 2> "$work/why" && grep -q 'it must have no spaces' "$work/why" || return 1
        done
    done
    test -e "$work/a b/lib/libcylfuse.so" && test -e "$work/a/include/cylfuse/kept"
}
check "paths with spaces are refused" refuses_spaces
# From here on it is somewhere else: nothing may remember where it was.
mv "$prefix" "$work/moved"
prefix=$work/moved

printf '\n-- headers\n'
read -ra opencv <<< "$(pkg-config --cflags opencv4 eigen3 | sed 's/-I/-isystem /g')"
pcl=(-isystem "$(find /usr/include -maxdepth 1 -name 'pcl-*' | sort | tail -n 1)")
warnings=(-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Werror -fsyntax-only)
compiles() { # compiles COMPILER STANDARD FILE: twice the headers in one unit, with every warning.
    "$1" "-std=$2" "${warnings[@]}" -I "$prefix/include" "${opencv[@]}" "${pcl[@]}" "$3"
}
every_constant() { # every_constant: enums.hpp has all constants of the C interface that are enumerated
    local missing
    missing=$(grep -oE '^#define CYLFUSE_[A-Z0-9_]+ [(0-9-]' include/cylfuse/cylfuse.h | cut -d ' ' -f 2 |
        grep -vE '^CYLFUSE_(VERSION_|ABI_VERSION|SCALAR_)' | while read -r name; do
            grep -qE " = $name," include/cylfuse/enums.hpp || echo "$name"
        done)
    [ -z "$missing" ] || { echo "not in enums.hpp: $missing"; return 1; }
}
check "enumerations" every_constant
every_name() { # every_name: to_string() gives each of them the name that it has in the C header
    {
        printf '#include <cylfuse/cylfuse.hpp>\n#include <cstdio>\nstatic int bad = 0;\n'
        printf 'static void same(const std::string &name, const char *expected)\n{\n'
        printf '    if (name != expected) { ++bad; std::printf("%%s, not %%s\\n", name.c_str(), expected); }\n}\n'
        printf 'int main()\n{\n'
        awk '/^enum class / { enumeration = $3; prefix = toupper($5) "_" }
            / = CYLFUSE_/ { sub(/,/, ""); printf "    same(to_string(cylfuse::%s::%s), \"%s\");\n", enumeration, $1, substr($3, length(prefix) + 1) }' \
            include/cylfuse/enums.hpp
        printf '    return bad;\n}\n'
    } > "$work/names.cpp"
    g++ -std=c++14 -I "$prefix/include" "$work/names.cpp" -L "$prefix/lib" -lcylfuse -Wl,-rpath,"$prefix/lib" -o "$work/names" && "$work/names"
}
check "names of constants" every_name
for header in callbacks cylfuse cylinder detector eigen enums error frame handle names opencv pcl pcl_detection pcl_segmentation types views; do
    printf '#include <cylfuse/%s.hpp>\n#include <cylfuse/%s.hpp>\n' $header $header > "$work/$header.cpp"
    check "$header.hpp by itself" compiles g++ c++14 "$work/$header.cpp"
done
for compiler in g++ clang++; do
    for standard in c++14 c++17 c++20; do
        check "all headers, $compiler, $standard" compiles $compiler $standard tests/cpp/second_unit.cpp
        check "without exceptions, $compiler, $standard" compiles $compiler $standard tests/cpp/test_no_exceptions.cpp
    done
done
printf '#include <cylfuse/cylfuse.hpp>\nvoid push(cylfuse::Fitter &f) { std::vector<std::array<int, 3>> p(9); f.push_points(p); }\n' > "$work/integers.cpp"
says_why() { # says_why COMPILER: coordinates that are no float and no double are refused in words
    ! compiles "$1" c++14 "$work/integers.cpp" > "$work/why" 2>&1 && grep -q 'coordinates must be float or double' "$work/why"
}
for compiler in g++ clang++; do
    check "points of integers, $compiler" says_why $compiler
done
printf '#define CYLFUSE_NO_EXCEPTIONS\n#include <cylfuse/cylfuse.hpp>\nvoid fit(cylfuse::Fitter &f) { f.clear(); f.fit(); }\n' > "$work/ignored.cpp"
warns_twice() { # warns_twice COMPILER STANDARD: without exceptions a call whose outcome nobody looks at gets a warning, with a value or without
    local count
    count=$("$1" "-std=$2" -fsyntax-only -I "$prefix/include" "$work/ignored.cpp" 2>&1 | grep -cE 'warning: .*(nodiscard|warn_unused_result)')
    [ "$count" = 2 ] || { echo "$count warnings"; return 1; }
}
for compiler in g++ clang++; do
    for standard in c++14 c++17; do
        check "an outcome that is ignored, $compiler, $standard" warns_twice $compiler $standard
    done
done
printf '#include <cylfuse/cylfuse.h>\n#include <cylfuse/cylfuse.h>\n' > "$work/header.c"
for compiler in gcc clang; do
    check "cylfuse.h, $compiler, C99" compiles $compiler c99 "$work/header.c"
done

printf '\n-- ways in\n'
mkdir "$work/project"
block README.md c 1 > "$work/project/main.c"
block README.md cpp 1 > "$work/project/main.cpp"
block README.md cmake 1 > "$work/project/CMakeLists.txt"
check "the README takes at most 5 lines of CMake" test "$(wc -l < "$work/project/CMakeLists.txt")" -le 5
check "the README takes at most 25 lines of C++" test "$(wc -l < "$work/project/main.cpp")" -le 25
by_pkg_config() { # by_pkg_config COMPILER FILE shared|static
    local flags libraries
    flags=$(pkg-config --cflags cylfuse) || return 1
    if [ "$3" = shared ]; then
        libraries=$(pkg-config --libs cylfuse)
    else
        libraries=$(pkg-config --libs --static cylfuse | sed 's/-lcylfuse/-l:libcylfuse.a/')
    fi
    # shellcheck disable=SC2086 # The flags are words.
    "$1" $flags "$work/project/$2" $libraries -lm -o "$work/program" || return 1
    if [ "$3" = static ] && readelf -d "$work/program" | grep libcylfuse; then return 1; fi
    prints '^radius 0\.50' env LD_LIBRARY_PATH="${library_path-}" "$work/program"
}
by_cmake() { # by_cmake SOURCES...: the README's project with this folder in which to find the package
    rm -rf "$work/build"
    cmake -S "$work/project" -B "$work/build" "$@" && cmake --build "$work/build" || return 1
    for program in "$work"/build/consumer*; do
        prints '^radius 0\.50' "$program" || return 1
    done
}
each_way() { # each_way WHERE CMAKE-ARGUMENTS...
    local where=$1 compiler linkage
    shift
    for linkage in shared static; do
        check "$where, pkg-config, C, $linkage" by_pkg_config cc main.c $linkage
        check "$where, pkg-config, C++, $linkage" by_pkg_config c++ main.cpp $linkage
    done
    block README.md cmake 1 > "$work/project/CMakeLists.txt"
    sed -i 's/add_executable(\([a-z]*\)/add_executable(consumer/; s/target_link_libraries(\([a-z]*\)/target_link_libraries(consumer/' "$work/project/CMakeLists.txt"
    check "$where, the CMake project of the README" by_cmake "$@"
    cp tests/cpp/consumer.cmake "$work/project/CMakeLists.txt"
    check "$where, CMake, C and C++, shared and static" by_cmake "$@"
}
check "pkg-config does not find what is not installed" not pkg-config --exists cylfuse
library_path=$prefix/lib PKG_CONFIG_PATH=$prefix/lib/pkgconfig
export PKG_CONFIG_PATH
each_way "moved prefix" -DCMAKE_PREFIX_PATH="$prefix"
check "another version is refused" not by_cmake -DCMAKE_PREFIX_PATH="$prefix" -DWANTED=0.1
unset library_path PKG_CONFIG_PATH

printf '\n-- Debian packages\n'
check "make deb" "${make[@]}" deb
packages=${CARGO_TARGET_DIR:-target}/deb
# It reads each member of the static library by itself, on one processor, and may do so beside what follows.
lintian --fail-on error,warning "$packages"/*.deb > "$work/lintian" 2>&1 &
lintian=$!
lintian_ends() {
    local status=0
    wait "$lintian" || status=$?
    cat "$work/lintian"
    return "$status"
}
check "the packages install" alone dpkg -i "$packages"/*.deb
each_way "Debian packages"
check "the packages go" alone dpkg -P libcylfuse-dev "libcylfuse${soname#libcylfuse.so.}"

printf '\n-- tests and examples\n'
built() { # built FOLDER SOURCE CMAKE-ARGUMENTS...
    cmake -S "$2" -B "$work/$1" -DCMAKE_PREFIX_PATH="$prefix" "${@:3}" && cmake --build "$work/$1" -j "$jobs"
}
# Where the kernel draws addresses at random over a wide range, memory comes to lie where the sanitizers of gcc 12 keep their
# own now and then.
fixed=(setarch -R)
"${fixed[@]}" true 2> /dev/null || fixed=()
tested() { # tested FOLDER: counts each test of CTest
    local all bad
    LD_LIBRARY_PATH=$prefix/lib "${fixed[@]}" ctest --test-dir "$work/$1" -j "$jobs" --output-on-failure > "$work/ctest"
    all=$(sed -n 's/.* out of \([0-9]*\)$/\1/p' "$work/ctest")
    bad=$(sed -n 's/.* \([0-9]*\) tests\{0,1\} failed out of .*/\1/p' "$work/ctest")
    grep -E 'Test +#' "$work/ctest"
    [ "${bad:-1}" = 0 ] || cat "$work/ctest"
    passed=$((passed + ${all:-0} - ${bad:-0}))
    failed=$((failed + ${bad:-1}))
}
sanitize="-DEIGEN_MALLOC_ALREADY_ALIGNED=1 -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all"
strict="-Wall -Wextra -Wpedantic -Werror"
check "examples build" built examples examples-cpp -DCMAKE_C_FLAGS="$strict -g" -DCMAKE_CXX_FLAGS="$strict -g"
check "tests build" built tests tests/cpp -DEXAMPLES="$work/examples" -DVALGRIND=ON
tested tests
check "examples build with sanitizers" built examples-sanitized examples-cpp -DCMAKE_BUILD_TYPE=None \
    -DCMAKE_C_FLAGS="$sanitize" -DCMAKE_CXX_FLAGS="$sanitize"
check "tests build with sanitizers" built tests-sanitized tests/cpp -DEXAMPLES="$work/examples-sanitized" -DSANITIZE=ON
tested tests-sanitized

check "lintian finds nothing" lintian_ends

printf '\n-- against PCL: frames of tests/data, and of ../shared where it is\n'
for frames in tests/data/frames ../shared/frames/paper; do
    [ -d "$frames" ] || { echo "skipped: no $frames"; continue; }
    check "table of $frames" "$work/tests/compare_with_pcl" "$frames"/*
    cat "$work/log"
done

printf '\n-- reference and documents\n'
check "doxygen" env OUTPUT="$work/doxygen" doxygen docs/Doxyfile
check "the reference is there" test -s "$work/doxygen/html/index.html"
block docs/start/cpp.md cpp 1 > "$work/start.cpp"
check "the page to start in C++" compiles g++ c++14 "$work/start.cpp"
block docs/from-pcl.md cpp 1 > "$work/with_pcl.cpp"
block docs/from-pcl.md cpp 2 > "$work/with_cylfuse.cpp"
block docs/from-pcl.md cpp 3 > "$work/with_image.cpp"
block docs/segment-a-scene.md cpp 1 > "$work/scene.cpp"
block docs/segment-a-scene.md cpp 2 > "$work/scene_with_eigen.cpp"
block docs/segment-a-scene.md cpp 3 > "$work/scene_with_pcl.cpp"
check "the page from PCL, PCL" compiles g++ c++14 "$work/with_pcl.cpp"
check "the page from PCL, cylfuse" compiles g++ c++14 "$work/with_cylfuse.cpp"
check "the page from PCL, image" compiles g++ c++14 "$work/with_image.cpp"
check "the page on scenes, C++" compiles g++ c++14 "$work/scene.cpp"
check "the page on scenes, Eigen" compiles g++ c++14 "$work/scene_with_eigen.cpp"
check "the page on scenes, PCL" compiles g++ c++14 "$work/scene_with_pcl.cpp"

printf '\ncpp: %s passed, %s failed\n' $passed $failed
[ $failed = 0 ]

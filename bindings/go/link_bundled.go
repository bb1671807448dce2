//go:build !cylfuse_system

package cylfuse

// The archive that package.sh puts into the module: programs need nothing else at run time. It lies beside the sources,
// because `go mod vendor` leaves out folders without Go files.

// #cgo linux,amd64 LDFLAGS: ${SRCDIR}/libcylfuse_linux_amd64.a -lm -lpthread -ldl
// #cgo linux,arm64 LDFLAGS: ${SRCDIR}/libcylfuse_linux_arm64.a -lm -lpthread -ldl
// #if !defined(__linux__) || !(defined(__x86_64__) || defined(__aarch64__))
// #error "this module has no native library for this system and machine: build with -tags cylfuse_system"
// #endif
import "C"

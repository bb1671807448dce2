//go:build !cylfuse_system

package cylfuse

// The archive that package.sh puts into the module: programs need nothing else at run time.

// #cgo linux,amd64 LDFLAGS: ${SRCDIR}/native/linux_amd64/libcylfuse.a -lm -lpthread -ldl
// #cgo linux,arm64 LDFLAGS: ${SRCDIR}/native/linux_arm64/libcylfuse.a -lm -lpthread -ldl
import "C"

//go:build cylfuse_system

package cylfuse

// A library of the system, or the one that CGO_LDFLAGS names.

// #cgo LDFLAGS: -lcylfuse
import "C"

//go:build cgo

package cylfuse

// #include "bridge.h"
import "C"

// Describe gives the name of the warning in C, a colon, and what it means in a few words; of several warnings, ask for each.
func (flags Flags) Describe() string {
	return C.GoString(C.cylfuse_flag_string(C.cylfuse_result_flags(flags)))
}

// Describe gives the name of the reason in C, a colon, and what it means in a few words.
func (termination Termination) Describe() string {
	return C.GoString(C.cylfuse_termination_string(C.cylfuse_termination(termination)))
}

// Describe gives the name of the start in C, a colon, and what it means in a few words.
func (start Start) Describe() string {
	return C.GoString(C.cylfuse_start_string(C.cylfuse_start(start)))
}

// Describe gives the name of the state in C, a colon, and what it means in a few words.
func (state EndState) Describe() string {
	return C.GoString(C.cylfuse_end_state_string(C.cylfuse_end_state(state)))
}

// Describe gives the name of the source in C, a colon, and what it means in a few words.
func (source EndSource) Describe() string {
	return C.GoString(C.cylfuse_end_source_string(C.cylfuse_end_source(source)))
}

// Describe gives the name of the status in C, a colon, and what it means in a few words.
func (status LimbStatus) Describe() string {
	return C.GoString(C.cylfuse_limb_status_string(C.cylfuse_limb_status(status)))
}

// Describe gives the name of the part in C, a colon, and what it means in a few words.
func (part Part) Describe() string { return C.GoString(C.cylfuse_part_string(C.cylfuse_part(part))) }

// Describe gives the name of the conformity in C, a colon, and what it means in a few words.
func (conformity Conformity) Describe() string {
	return C.GoString(C.cylfuse_conformity_string(C.cylfuse_conformity(conformity)))
}

//go:build cgo

package cylfuse

// #include "bridge.h"
import "C"

// Conformity is what a measurement says about a tolerance.
type Conformity int32

const (
	// Undecided: its uncertainty reaches over a limit or is not known, or a warning puts it in doubt.
	Undecided Conformity = C.CYLFUSE_CONFORMITY_UNDECIDED
	// Conforming: the value is within the limits with all of its uncertainty.
	Conforming Conformity = C.CYLFUSE_CONFORMITY_CONFORMING
	// NotConforming: the value is outside the limits with all of its uncertainty.
	NotConforming Conformity = C.CYLFUSE_CONFORMITY_NOT_CONFORMING
)

// String names the conformity.
func (conformity Conformity) String() string {
	return name(conformity, 0, "undecided", "conforming", "not conforming")
}

// Tolerance is the limits of a radius, a diameter or another length.
type Tolerance struct {
	// Lower and Upper conform themselves; an infinite one is none.
	Lower, Upper float64
	// Coverage is the coverage factor k: standard deviations on either side of a value. 0 = 2.
	Coverage float64
}

// Decide says by the rule of ISO 14253-1 whether a length conforms: only where the value with Coverage deviations on either
// side lies within the limits, and not only where it lies outside. A deviation that is NaN, or 0 as of a radius that the
// limits of the fit fix, decides nothing, nor do flags with a warning of which a deviation says nothing, such as FlagPoorFit
// or FlagRadiusAtLimit. A wrong scale of the depth and wrong intrinsics are in no deviation.
func (tolerance Tolerance) Decide(value, deviation float64, flags Flags) (Conformity, error) {
	var conformity C.cylfuse_conformity
	err := withoutHandle(func() C.cylfuse_status {
		return C.cylfuse_decide_conformity(C.double(value), C.double(deviation), C.cylfuse_result_flags(flags),
			C.double(tolerance.Lower), C.double(tolerance.Upper), C.double(tolerance.Coverage), &conformity)
	})
	return Conformity(conformity), err
}

// RadiusConforms says whether the radius conforms to a tolerance, by its deviation and the warnings.
func (result *Result) RadiusConforms(tolerance Tolerance) (Conformity, error) {
	return tolerance.Decide(result.Cylinder.Radius, result.RadiusDeviation, result.Flags)
}

// DiameterConforms says the same of the diameter, with limits of the diameter.
func (result *Result) DiameterConforms(tolerance Tolerance) (Conformity, error) {
	return tolerance.Decide(2*result.Cylinder.Radius, 2*result.RadiusDeviation, result.Flags)
}

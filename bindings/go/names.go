//go:build cgo

package cylfuse

import (
	"fmt"
	"strings"
)

// String names the method.
func (method Method) String() string { return name(method, 0, "fused", "points", "RANSAC", "Eberly") }

// String names the objective.
func (objective Objective) String() string { return name(objective, 0, "robust", "paper") }

// String names the start.
func (start Start) String() string {
	return name(start, 0, "auto", "limbs", "moments", "RANSAC", "model", "last")
}

// String names the rule.
func (wall NearWall) String() string { return name(wall, 0, "auto", "on", "off") }

// String names the coordinates.
func (chart Chart) String() string { return name(chart, 0, "auto", "local", "orthonormal") }

// String names the use.
func (use EdgeUse) String() string { return name(use, 0, "refine", "as given") }

// String names the rule.
func (rule ExtentRule) String() string { return name(rule, 0, "auto", "extremes", "located") }

// String names the model.
func (model DistortionModel) String() string {
	return name(model, 0, "none", "Brown-Conrady", "Kannala-Brandt")
}

// String names the reason.
func (termination Termination) String() string {
	return name(termination, 0, "none", "cost", "stalled", "max iterations", "radius ran away", "gradient", "step")
}

// String names the residuals.
func (kind ResidualKind) String() string { return name(kind, ResidualPoints, "points", "edges") }

// String names the layout.
func (layout Layout) String() string { return name(layout, 0, "packed", "organised") }

// String names the state.
func (state EndState) String() string { return name(state, 0, "unknown", "seen", "cut", "hidden") }

// String names the source.
func (source EndSource) String() string {
	return name(source, 0, "extreme", "mask", "image", "border", "points")
}

// String names the part.
func (part Part) String() string {
	return name(int(part), int(PartBody), "body", "cap", "inner wall", "other", "behind")
}

// String names the status.
func (status LimbStatus) String() string {
	return name(status, 0, "located", "not searched", "no limbs", "too short", "no edge", "out of reach", "uncertain",
		"patchy", "same line")
}

// String names the order.
func (order ColourOrder) String() string { return name(order, ColourRGB, "RGB", "BGR", "RGBA", "BGRA") }

// String names the data, separated by commas.
func (input Input) String() string {
	return bitNames(uint32(input), "points", "depth", "edges", "image")
}

// String names the phase.
func (phase Phase) String() string { return name(phase, PhaseStart, "start", "solve") }

// String names the use.
func (use ImageUse) String() string { return name(use, 0, "auto", "ignore") }

// String names the phase.
func (phase DetectionPhase) String() string { return name(phase, DetectionSearch, "search", "fit") }

// String names the level.
func (level LogLevel) String() string {
	return name(level, 0, "off", "error", "warning", "info", "debug")
}

// String names the warnings, separated by commas.
func (flags Flags) String() string {
	return bitNames(uint32(flags), "edges ignored", "segments unusable", "edges cross", "edges coincide", "edges behind",
		"scale held", "weak radius", "resolution lost", "not converged", "hidden wall", "camera inside", "points not finite",
		"points and limbs disagree", "radius at limit", "axis at limit", "uncertainty unknown",
		"depth shifted", "mask ends with depth", "poor fit", "body tapers", "mask disagrees")
}

// bitNames are the names of the bits that are set, the lowest of which has the first name.
func bitNames(bits uint32, names ...string) string {
	var set []string
	for bit := 0; bits>>bit != 0; bit++ {
		if bits>>bit&1 != 0 {
			set = append(set, name(bit, 0, names...))
		}
	}
	return strings.Join(set, ", ")
}

// name is that of a value, the lowest of which has the first name; the number when a later library has made it up.
func name[T ~int | ~int32](value, lowest T, names ...string) string {
	if i := int(value - lowest); 0 <= i && i < len(names) {
		return names[i]
	}
	return fmt.Sprint(int(value))
}

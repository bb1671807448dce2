package cylfuse

import (
	"math"
	"testing"
)

func TestAPlanExpectsMoreOfANearCylinder(t *testing.T) {
	camera := Intrinsics{Width: 640, Height: 480, FX: 570, FY: 570, CX: 319.5, CY: 239.5}
	plan := Plan{Distance: 0.7, Radius: 0.03, Length: 0.1, Tilt: 0.35, Turn: 0.42}
	scatter, near, err := plan.Expect(camera)
	if err != nil || !(scatter.Radius > 0 && scatter.Radius < near.Radius && scatter.Length < near.Length) {
		t.Fatal(scatter, near, err)
	}
	plan.Noise = &[6]float64{0.01, 0, 0, 9, 0.014, 0.7}
	if noisy, _, err := plan.Expect(camera); err != nil || !(noisy.Position > 2*scatter.Position) {
		t.Fatal(noisy, err)
	}
	plan = Plan{Distance: 1.4, Radius: 0.03, Length: 2}
	if _, far, err := plan.Expect(camera); err != nil || !(far.Radius > near.Radius && math.IsNaN(far.Length)) {
		t.Fatal(far, err)
	}
	plan.Radius = -1
	if _, _, err := plan.Expect(camera); err == nil {
		t.Fatal("a negative radius was taken")
	}
}

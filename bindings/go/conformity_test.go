package cylfuse

import (
	"math"
	"testing"
)

func TestTheIntervalDecides(t *testing.T) {
	for _, c := range []struct {
		value, deviation, coverage float64
		flags                      Flags
		want                       Conformity
	}{
		{20, 0.12, 0, 0, Conforming},
		{20, 0.13, 0, 0, Undecided},
		{20, 0.13, 1, 0, Conforming},
		{21, 0.3, 0, 0, NotConforming},
		{20, math.NaN(), 0, 0, Undecided},
		{20, 0, 0, 0, Undecided},
		{20, 0.12, 0, FlagWeakRadius, Conforming},
		{20, 0.12, 0, FlagWeakRadius | FlagPoorFit, Undecided},
	} {
		tolerance := Tolerance{Lower: 19.5, Upper: 20.25, Coverage: c.coverage}
		if got, err := tolerance.Decide(c.value, c.deviation, c.flags); err != nil || got != c.want {
			t.Error(c, got, err)
		}
	}
	if got, err := (Tolerance{Lower: 19.5, Upper: math.Inf(1)}).Decide(20, 0.13, 0); err != nil || got.String() != "conforming" {
		t.Error(got, err)
	}
	_, err := Tolerance{Lower: 21, Upper: 19}.Decide(20, 0.1, 0)
	wantStatus(t, err, StatusInvalidArgument, "21 to 19")
}

func TestAResultIsJudgedAndAFitterCloned(t *testing.T) {
	points := pipe()
	for k := 2; k < len(points); k += 3 {
		points[k] += 0.002 * math.Sin(7*float64(k))
	}
	fitter := newFitter(t)
	if _, err := fitter.Intrinsics(); err == nil {
		t.Error("intrinsics that were not set")
	}
	camera := Intrinsics{Width: 640, Height: 480, FX: 570, FY: 571, CX: 319.5, CY: 239.5,
		DistortionModel: DistortionKannalaBrandt, Distortion: [8]float64{0.01, 0, 0, -0.002}}
	must(t, fitter.SetIntrinsics(camera))
	must(t, fitter.PushPoints(Points[float64]{Data: points}, nil))
	result, err := fitter.Fit()
	must(t, err)
	radius, deviation := result.Cylinder.Radius, result.RadiusDeviation
	if !(0 < deviation && deviation < 0.1*radius) {
		t.Fatal(radius, deviation)
	}
	for width, want := range map[float64]Conformity{2.1: Conforming, 1.9: Undecided} {
		got, err := result.RadiusConforms(Tolerance{Lower: radius - width*deviation, Upper: radius + width*deviation})
		if err != nil || got != want {
			t.Error(width, got, err)
		}
		got, err = result.DiameterConforms(Tolerance{Lower: 2 * (radius - width*deviation), Upper: 2 * (radius + width*deviation)})
		if err != nil || got != want {
			t.Error("diameter", width, got, err)
		}
	}
	if got, err := result.DiameterConforms(Tolerance{Upper: radius}); err != nil || got != NotConforming {
		t.Error(got, err)
	}

	must(t, fitter.SetProgress(func(Progress) bool { return false }))
	clone, err := fitter.Clone()
	must(t, err)
	defer clone.Close()
	if back, err := clone.Intrinsics(); err != nil || back != camera {
		t.Error(back, err)
	}
	again, err := clone.Fit() // Without the callback.
	must(t, err)
	if again.Cylinder != result.Cylinder {
		t.Error(again.Cylinder, result.Cylinder)
	}
	must(t, clone.Clear())
	if counts, err := fitter.Counts(); err != nil || counts.PointsGiven != 200 {
		t.Error(counts, err)
	}
	must(t, fitter.Close())
	if _, err := fitter.Clone(); err != ErrClosed {
		t.Error(err)
	}
}

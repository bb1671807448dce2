package cylfuse

import (
	"errors"
	"strings"
	"testing"
)

// batchFitters holds a pipe each; the third has a line only.
func batchFitters(t *testing.T) []*Fitter {
	fitters := make([]*Fitter, 8)
	for i := range fitters {
		fitters[i] = newFitter(t)
		points := pipe()[:3*(100+10*i)]
		if i == 2 {
			points = []float64{0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 3, 1, 0, 4, 1, 0, 5, 1, 0, 6, 1, 0, 7, 1, 0, 8, 1}
		}
		must(t, fitters[i].PushPoints(Points[float64]{Data: points}, nil))
	}
	return fitters
}

func TestFitAll(t *testing.T) {
	alone := batchFitters(t)
	for _, threads := range []int{0, 1, 3} {
		fitters := batchFitters(t)
		heard := make([]bool, len(fitters))
		errs, err := FitAll(fitters, threads, func(index int, status Status) bool {
			heard[index] = status == 0 || index == 2 && status == StatusCollinearPoints
			return true
		})
		must(t, err)
		for i, fitter := range fitters {
			if !heard[i] {
				t.Errorf("%d was not heard of", i)
			}
			want, wantErr := alone[i].Fit()
			if i == 2 {
				wantStatus(t, errs[i], StatusCollinearPoints, wantErr.(*Error).Message)
				continue
			}
			must(t, errs[i])
			got, err := fitter.Result()
			must(t, err)
			if got.Cylinder != want.Cylinder || got.Covariance != want.Covariance {
				t.Errorf("%d: %+v, %+v", i, got.Cylinder, want.Cylinder)
			}
		}
	}
}

func TestFitAllStopsAndRefuses(t *testing.T) {
	fitters := batchFitters(t)
	errs, err := FitAll(fitters, 1, func(index int, status Status) bool { return index < 1 })
	wantStatus(t, err, StatusCancelled, "")
	if errs[1] != nil || !errors.Is(errs[7], StatusCancelled) {
		t.Errorf("%v", errs)
	}
	func() {
		defer func() {
			if thrown := recover(); thrown != "from the callback" {
				t.Errorf("%v", thrown)
			}
		}()
		FitAll(fitters, 2, func(int, Status) bool { panic("from the callback") })
	}()
	_, err = FitAll([]*Fitter{fitters[0], fitters[1], fitters[0]}, 1, nil)
	wantStatus(t, err, StatusInvalidArgument, "fitters[2] is the same as fitters[0]; it must be another fitter")
	_, err = FitAll([]*Fitter{fitters[0], nil}, 1, nil)
	wantStatus(t, err, StatusNullPointer, "fitters[1] is nil; it must be a fitter")
	must(t, fitters[3].Close())
	if _, err = FitAll(fitters, 1, nil); !errors.Is(err, ErrClosed) || !strings.HasPrefix(err.Error(), "fitters[3]: ") {
		t.Error(err)
	}
	errs, err = FitAll(nil, 0, nil)
	if err != nil || len(errs) != 0 {
		t.Error(errs, err)
	}
}

// TestFitAllBesideABusyFitter has one fitter that is in a fit, whose callback makes the call, and one that is in a push.
func TestFitAllBesideABusyFitter(t *testing.T) {
	fitters := batchFitters(t)[:2]
	must(t, fitters[0].SetProgress(func(Progress) bool {
		statuses := map[int]Status{}
		errs, err := FitAll(fitters, 2, func(index int, status Status) bool {
			statuses[index] = status
			return true
		})
		must(t, err)
		if len(errs) != 2 || errs[1] != nil || statuses[0] != StatusBusy || statuses[1] != 0 {
			t.Errorf("%v, %v", errs, statuses)
		}
		wantStatus(t, errs[0], StatusBusy, "")
		return false
	}))
	_, err := fitters[0].Fit()
	wantStatus(t, err, StatusCancelled, "")
	must(t, fitters[0].SetProgress(nil))

	// The log of a push, where only the library knows that the fitter is busy.
	heard := false
	must(t, fitters[0].SetLog(LogDebug, func(LogLevel, string) {
		errs, err := FitAll(fitters, 2, nil)
		must(t, err)
		if !heard && (errs[1] != nil || !strings.Contains(errs[0].Error(), "the handle is busy in another call")) {
			t.Errorf("%v", errs)
		}
		wantStatus(t, errs[0], StatusBusy, "")
		heard = true
	}))
	must(t, fitters[0].PushPoints(Points[float64]{Data: pipe()}, nil))
	if !heard {
		t.Error("the push logged nothing")
	}
}

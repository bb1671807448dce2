package cylfuse

import (
	"errors"
	"os"
	"os/exec"
	"runtime"
	"strings"
	"sync"
	"testing"
)

func TestASearchIsNotReadBeforeItsEnd(t *testing.T) {
	detector := newDetector(t)
	_, err := detector.Detect(pairFrame(t, true))
	must(t, err)
	detector.last.Lock() // As a search does.
	for name, call := range map[string]func() error{
		"detections": func() error { _, err := detector.Detections(); return err },
		"labels":     func() error { _, err := detector.Labels(); return err },
		"indices":    func() error { _, err := detector.Indices(1); return err },
		"fitter":     func() error { _, err := detector.Fitter(1); return err },
	} {
		if err := call(); !errors.Is(err, StatusBusy) {
			t.Errorf("%s: %v", name, err)
		}
	}
	detector.last.Unlock()
	indices, err := detector.Indices(1)
	if err != nil || len(indices) == 0 {
		t.Error(indices, err)
	}
}

// TestAMissingExtentHasItsReason runs itself again with a library that finds no extents, which test.sh makes.
func TestAMissingExtentHasItsReason(t *testing.T) {
	library := os.Getenv("CYLFUSE_WITHOUT_EXTENTS")
	if library == "" {
		t.Skip("CYLFUSE_WITHOUT_EXTENTS is not set: test.sh makes that library")
	}
	if os.Getenv("LD_PRELOAD") != library {
		again := exec.Command(os.Args[0], "-test.run=^TestAMissingExtentHasItsReason$")
		again.Env = append(os.Environ(), "LD_PRELOAD="+library)
		if printed, err := again.CombinedOutput(); err != nil {
			t.Errorf("%v: %s", err, printed)
		}
		return
	}
	found, err := newDetector(t).Detect(pairFrame(t, true))
	must(t, err)
	if len(found) != 2 || found[0].Extent != nil || found[1].Extent != nil {
		t.Fatalf("%+v", found)
	}
	wantStatus(t, found[1].ExtentError, StatusEdgeGeometry, "EDGE_GEOMETRY: made up")
}

func TestThreadsOfADetector(t *testing.T) {
	frame := pairFrame(t, true)
	var scenes [2][]Detection
	for k := range scenes {
		detector, options := newDetector(t), DefaultDetectorOptions()
		options.MaxThreads = uint32(1 + 2*k)
		must(t, detector.SetOptions(options))
		var err error
		scenes[k], err = detector.Detect(frame)
		must(t, err)
	}
	sameScene(t, scenes[0], scenes[1])
}

func TestWhatNeedsASearch(t *testing.T) {
	detector := newDetector(t)
	for name, call := range map[string]func() error{
		"detections": func() error { _, err := detector.Detections(); return err },
		"labels":     func() error { _, err := detector.Labels(); return err },
		"indices":    func() error { _, err := detector.Indices(0); return err },
		"fitter":     func() error { _, err := detector.Fitter(0); return err },
	} {
		if err := call(); !errors.Is(err, StatusBadState) || !strings.Contains(err.Error(), "search a frame or points first") {
			t.Errorf("%s: %v", name, err)
		}
	}
	frame, err := NewFrame()
	must(t, err)
	_, err = detector.Detect(frame)
	wantStatus(t, err, StatusBadState, "intrinsics")
	must(t, frame.SetIntrinsics(pairCamera))
	_, err = detector.Detect(frame)
	wantStatus(t, err, StatusBadState, "depth")
	must(t, frame.Close())
	if _, err = detector.Detect(frame); err != ErrClosed {
		t.Error(err)
	}
	found, err := detector.DetectPoints(Points[float64]{})
	labels, failure := detector.Labels()
	if err != nil || failure != nil || len(found) != 0 || len(labels.Data) != 0 {
		t.Errorf("%v, %v, %v, %v", found, err, labels, failure)
	}
	if _, err = detector.DetectPoints(Points[float64]{Data: make([]float64, 5)}); !errors.Is(err, ErrShape) {
		t.Error(err)
	}
	must(t, detector.Close())
	if _, err = detector.Labels(); err != ErrClosed {
		t.Error(err)
	}
	if err = new(Detector).Cancel(); err != ErrClosed {
		t.Error(err)
	}
}

func TestProgressOfADetector(t *testing.T) {
	detector, frame := newDetector(t), pairFrame(t, true)
	var states []DetectionProgress
	must(t, detector.SetProgress(func(progress DetectionProgress) bool {
		states = append(states, progress)
		if _, err := detector.Labels(); !errors.Is(err, StatusBusy) {
			t.Errorf("a call from the callback: %v", err)
		}
		if _, err := detector.Detect(frame); !errors.Is(err, StatusBusy) {
			t.Errorf("a search from the callback: %v", err)
		}
		if err := detector.Close(); !errors.Is(err, StatusBusy) {
			t.Errorf("closed from the callback: %v", err)
		}
		return true
	}))
	found, err := detector.Detect(frame)
	must(t, err)
	last := states[len(states)-1]
	if states[0].Phase != DetectionSearch || states[1].Phase != DetectionFit || last.FitsDone != last.Fits ||
		int(last.Fits) != len(states)-2 || int(last.Fits) < len(found) {
		t.Errorf("%v", states)
	}
	for _, stop := range []func(DetectionProgress) bool{
		func(DetectionProgress) bool { return false },
		func(DetectionProgress) bool { return detector.Cancel() == nil },
	} {
		must(t, detector.SetProgress(stop))
		_, err = detector.Detect(frame)
		wantStatus(t, err, StatusCancelled, "cancelled by the caller")
	}
	must(t, detector.SetProgress(func(DetectionProgress) bool { panic("of the caller") }))
	func() {
		defer func() {
			if thrown := recover(); thrown != "of the caller" {
				t.Errorf("%v", thrown)
			}
		}()
		detector.Detect(frame)
	}()
	must(t, detector.SetProgress(nil))
	// The last scene is still there.
	again, err := detector.Detections()
	must(t, err)
	sameScene(t, found, again)
	must(t, detector.Cancel())
	_, err = detector.Detect(frame)
	must(t, err)
}

func TestManyReadersOfAScene(t *testing.T) {
	detector := newDetector(t)
	found, err := detector.Detect(pairFrame(t, true))
	must(t, err)
	var group sync.WaitGroup
	for k := 0; k < 4; k++ {
		group.Add(1)
		go func() {
			defer group.Done()
			for round := 0; round < 10; round++ {
				again, err := detector.Detections()
				if err != nil {
					t.Error(err)
					return
				}
				sameScene(t, found, again)
				labels, err := detector.Labels()
				if err != nil || len(labels.Data) != pairPixels {
					t.Errorf("%d labels, %v", len(labels.Data), err)
				}
				fitter, err := detector.Fitter(1)
				if err != nil {
					t.Error(err)
					return
				}
				if err := fitter.Close(); err != nil {
					t.Error(err)
				}
			}
		}()
	}
	group.Wait()
}

func TestForgottenDetectorsAreFreed(t *testing.T) {
	if testing.Short() {
		t.Skip("the memory is measured without what -short is for")
	}
	cloud := Points[float64]{Data: make([]float64, 3*640*480), Width: 640, Height: 480}
	forget := func(count int) {
		for k := 0; k < count; k++ {
			detector, err := NewDetector()
			must(t, err)
			// A callback that refers to its detector must not keep it.
			must(t, detector.SetProgress(func(DetectionProgress) bool { return detector != nil }))
			_, err = detector.DetectPoints(cloud)
			must(t, err)
		}
		runtime.GC()
		finalizersHaveRun()
	}
	// The arenas of the C allocator fill in steps.
	for round := 0; round < 5; round++ {
		forget(5)
	}
	// Their labels would be 88 MB.
	memoryStaysFlat(t, 60, func() {
		for round := 0; round < 30; round++ {
			forget(5)
		}
	})
}

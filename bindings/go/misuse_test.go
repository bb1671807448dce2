package cylfuse

import (
	"errors"
	"runtime"
	"sync"
	"testing"
)

// What a careless or hostile caller does.

// cgo refuses a void pointer to memory that has Go pointers in it, and numbers may well lie there.
func TestDataInAStructWithPointers(t *testing.T) {
	type frame struct {
		xyz     [600]float64
		weights [200]float64
		mask    [200]uint8
		name    *string
	}
	held := &frame{name: new(string)}
	copy(held.xyz[:], pipe())
	for i := range held.mask {
		held.weights[i], held.mask[i] = 1, 1
	}
	fitter := newFitter(t)
	points := Points[float64]{Data: held.xyz[:], Weights: held.weights[:], Normals: held.xyz[:]}
	must(t, fitter.PushPoints(points, &Mask{Data: held.mask[:], Width: 200, Height: 1}))
	_, err := fitter.Fit()
	must(t, err)
}

func TestShapesAreCheckedBeforeTheCall(t *testing.T) {
	fitter := newFitter(t)
	must(t, fitter.SetIntrinsics(Intrinsics{Width: 4, Height: 2, FX: 1, FY: 1}))
	xyz := make([]float64, 12)
	for name, err := range map[string]error{
		"no width":        fitter.PushPoints(Points[float64]{Data: xyz, Height: 2}, nil),
		"short stride":    fitter.PushPoints(Points[float64]{Data: xyz, PointStride: 2}, nil),
		"wide stride":     fitter.PushPoints(Points[float64]{Data: xyz, Width: 1 << 32, PointStride: 1 << 33, RowStride: 1}, nil),
		"negative camera": fitter.SetIntrinsics(Intrinsics{Width: -4, Height: 2, FX: 1, FY: 1}),
		"huge camera":     fitter.SetIntrinsics(Intrinsics{Width: 1<<32 + 4, Height: 2, FX: 1, FY: 1}),
		"huge image":      fitter.PushImage(GreyImage[uint8]{Data: make([]uint8, 8), Width: 1<<32 + 4, Height: 2}),
		"no whole points": fitter.PushPoints(Points[float64]{Data: xyz[:11]}, nil),
		"too few":         fitter.PushPoints(Points[float64]{Data: xyz, Width: 5}, nil),
		"negative":        fitter.PushPoints(Points[float64]{Data: xyz, PointStride: -3}, nil),
		"overflow":        fitter.PushPoints(Points[float64]{Data: xyz, Width: 1 << 61, PointStride: 8}, nil),
		"rows overflow":   fitter.PushPoints(Points[float64]{Data: xyz, Width: 1, Height: 1 << 62, RowStride: 1 << 59}, nil),
		"weights":         fitter.PushPoints(Points[float64]{Data: xyz, Weights: xyz[:3]}, nil),
		"normals":         fitter.PushPoints(Points[float64]{Data: xyz, Normals: xyz[:3]}, nil),
		"mask":            fitter.PushPoints(Points[float64]{Data: xyz}, &Mask{Data: nil, Width: 4, Height: 1}),
		"depth":           fitter.PushDepth(DepthImage[float32]{Data: make([]float32, 7), Width: 4, Height: 2}, nil),
		"image":           fitter.PushImage(GreyImage[uint8]{Data: make([]uint8, 22), Width: 4, Height: 2, PixelStride: 3, RowStride: 13}),
		"colours":         fitter.PushImage(ColourImage{Data: make([]uint8, 23), Order: ColourBGR, Width: 4, Height: 2}),
		"narrow colours":  fitter.PushImage(ColourImage{Data: make([]uint8, 24), Order: ColourRGBA, Width: 4, Height: 2}),
		"no order":        fitter.PushImage(ColourImage{Data: make([]uint8, 24), Width: 4, Height: 2}),
		"view":            fitter.SelectView(-1),
		"segments":        fitter.PushEdges(Segments[float32]{Data: make([]float32, 6)}),
		"segment weights": fitter.PushEdges(Segments[float32]{Data: make([]float32, 8), Weights: []float64{1}}),
		"reserve":         fitter.Reserve(-1, 0),
	} {
		if !errors.Is(err, ErrShape) {
			t.Errorf("%s: %v", name, err)
		}
	}
	want := "cylfuse: wrong shape: mask.Data has 7 numbers, too few for 4 x 2 with strides of 1 and 4 numbers"
	depth := DepthImage[float32]{Data: make([]float32, 8), Width: 4, Height: 2}
	if err := fitter.PushDepth(depth, &Mask{Data: make([]uint8, 7), Width: 4, Height: 2}); err == nil || err.Error() != want {
		t.Errorf("%v", err)
	}
	counts, err := fitter.Counts()
	must(t, err)
	if counts != (Counts{}) {
		t.Errorf("something was pushed: %+v", counts)
	}
}

func TestClosed(t *testing.T) {
	fitter, err := NewFitter()
	must(t, err)
	must(t, fitter.Close())
	must(t, fitter.Close())
	if _, err := fitter.Fit(); err != ErrClosed {
		t.Error(err)
	}
	if err := fitter.Cancel(); err != ErrClosed {
		t.Error(err)
	}
	var never Fitter
	if err := never.Clear(); err != ErrClosed {
		t.Error(err)
	}
	must(t, never.Close())
	if err := fitter.UseFrame(new(Frame), nil); err != ErrClosed {
		t.Error(err)
	}
}

func TestOneFitterInTwoGoroutinesIsRefused(t *testing.T) {
	fitter := newFitter(t)
	must(t, fitter.PushPoints(Points[float64]{Data: pipe()}, nil))
	// The first goroutine waits inside its fit until the other one was refused.
	inside, refused := make(chan struct{}), make(chan struct{})
	var once sync.Once
	must(t, fitter.SetProgress(func(Progress) bool {
		once.Do(func() { close(inside); <-refused })
		return true
	}))
	done := make(chan error)
	go func() {
		_, err := fitter.Fit()
		done <- err
	}()
	<-inside
	_, err := fitter.Fit()
	wantStatus(t, err, StatusBusy, "another call")
	wantStatus(t, fitter.Close(), StatusBusy, "another call")
	close(refused)
	must(t, <-done)

	// Whatever the order, a call works or is refused.
	must(t, fitter.SetProgress(nil))
	var group sync.WaitGroup
	for k := 0; k < 8; k++ {
		group.Add(1)
		go func() {
			defer group.Done()
			for round := 0; round < 200; round++ {
				if _, err := fitter.Fit(); err != nil && !errors.Is(err, StatusBusy) {
					t.Error(err)
				}
			}
		}()
	}
	group.Wait()
}

func TestCancelFromAnotherGoroutine(t *testing.T) {
	fitter := newFitter(t)
	must(t, fitter.PushPoints(Points[float64]{Data: pipe()}, nil))
	// The fit goes on only after the other goroutine has cancelled it.
	inside, cancelled := make(chan struct{}), make(chan error)
	var once sync.Once
	must(t, fitter.SetProgress(func(Progress) bool {
		once.Do(func() {
			close(inside)
			if err := <-cancelled; err != nil {
				t.Error(err)
			}
		})
		return true
	}))
	go func() {
		<-inside
		cancelled <- fitter.Cancel()
	}()
	_, err := fitter.Fit()
	wantStatus(t, err, StatusCancelled, "")
}

func TestCollectionDuringTheLastCall(t *testing.T) {
	for round := 0; round < 20; round++ {
		fitter, err := NewFitter()
		must(t, err)
		must(t, fitter.PushPoints(Points[float64]{Data: pipe()}, nil))
		// Nothing but the running call refers to the fitter: it must not be freed.
		must(t, fitter.SetProgress(func(Progress) bool { finalizersHaveRun(); return true }))
		_, err = fitter.Fit()
		must(t, err)
	}
}

func TestCallbackThatEndsItsGoroutine(t *testing.T) {
	fitter, err := NewFitter()
	must(t, err)
	must(t, fitter.PushPoints(Points[float64]{Data: pipe()}, nil))
	must(t, fitter.SetProgress(func(Progress) bool { runtime.Goexit(); return true }))
	done := make(chan struct{})
	go func() {
		defer close(done)
		_, _ = fitter.Fit()
	}()
	<-done
	// The library never came back from the callback: the fitter is lost, and says so.
	wantStatus(t, fitter.Clear(), StatusBusy, "")
	wantStatus(t, fitter.Close(), StatusBusy, "another call")
}

package cylfuse

import (
	"os"
	"runtime"
	"strconv"
	"strings"
	"testing"
)

// residentMegabytes is the memory of this process, the library's included.
func residentMegabytes(t testing.TB) float64 {
	text, err := os.ReadFile("/proc/self/status")
	if err != nil {
		t.Skip("no /proc/self/status on this system: ", err)
	}
	fields := strings.Fields(strings.SplitN(string(text), "VmRSS:", 2)[1])
	kilobytes, err := strconv.ParseFloat(fields[0], 64)
	must(t, err)
	return kilobytes / 1024
}

// memoryStaysFlat runs something that shall keep less than so much memory. A leak shows every time, what a collector is
// late with does not.
func memoryStaysFlat(t testing.TB, megabytes float64, use func()) {
	t.Helper()
	var growth float64
	for round := 0; round < 3; round++ {
		before := residentMegabytes(t)
		use()
		if growth = residentMegabytes(t) - before; growth < megabytes {
			return
		}
	}
	t.Errorf("%.1f MB more", growth)
}

func TestMemoryStaysFlat(t *testing.T) {
	if testing.Short() {
		t.Skip("the memory is measured without what -short is for")
	}
	xyz := pipe()
	cycle := func() {
		fitter, err := NewFitter()
		must(t, err)
		must(t, fitter.PushPoints(Points[float64]{Data: xyz}, nil))
		_, err = fitter.Fit()
		must(t, err)
		must(t, fitter.Close())
	}
	for k := 0; k < 1000; k++ {
		cycle()
	}
	runtime.GC()
	// The points alone of a tenth of the fitters would be 4.8 MB.
	memoryStaysFlat(t, 4, func() {
		for k := 0; k < 10000; k++ {
			cycle()
		}
		runtime.GC()
	})
}

// finalizersHaveRun returns when the objects that were garbage before have been freed.
func finalizersHaveRun() {
	for round := 0; round < 2; round++ {
		// Finalizers run one after the other, those of earlier garbage first.
		ran := make(chan struct{})
		sentinel := new([16]byte)
		runtime.SetFinalizer(sentinel, func(*[16]byte) { close(ran) })
		runtime.GC()
		<-ran
	}
}

func TestForgottenFittersAreFreed(t *testing.T) {
	if testing.Short() {
		t.Skip("the memory is measured without what -short is for")
	}
	xyz := make([]float64, 0, 30*600)
	for k := 0; k < 30; k++ {
		xyz = append(xyz, pipe()...)
	}
	forget := func(count int) {
		for k := 0; k < count; k++ {
			fitter, err := NewFitter()
			must(t, err)
			must(t, fitter.PushPoints(Points[float64]{Data: xyz}, nil))
			// A callback that refers to its fitter must not keep it.
			must(t, fitter.SetProgress(func(Progress) bool { return fitter.Cancel() == nil }))
		}
		finalizersHaveRun()
	}
	forget(100)
	// Their points would be 288 MB. The arenas of the C allocator fill to some 40 MB, then stay (seen over 8,000
	// fitters), so a quarter of a leak is told from none.
	memoryStaysFlat(t, 72, func() {
		for round := 0; round < 20; round++ {
			forget(100)
		}
	})
}

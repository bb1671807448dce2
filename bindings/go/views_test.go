package cylfuse

import (
	"errors"
	"fmt"
	"math"
	"regexp"
	"sync"
	"sync/atomic"
	"testing"
)

// canCamera is 0.5 m from the can of seenCan.
var canCamera = Intrinsics{Width: 160, Height: 120, FX: 140, FY: 140, CX: 79.5, CY: 59.5}

// seenCan is what canCamera sees of an upright can of radius 40 mm and length 100 mm, its axis 0.5 m away.
func seenCan() (DepthImage[float32], *Mask) {
	width, height := canCamera.Width, canCamera.Height
	depth := DepthImage[float32]{Data: make([]float32, width*height), Width: width, Height: height, Scale: 1}
	mask := &Mask{Data: make([]uint8, width*height), Width: width, Height: height}
	for i := range depth.Data {
		x := (float64(i%width) - canCamera.CX) / canCamera.FX
		y := (float64(i/width) - canCamera.CY) / canCamera.FY
		// The ray z (x, y, 1) meets x² z² + (z - 0.5)² = 0.04².
		z := (0.5 - math.Sqrt(0.25-(1+x*x)*(0.25-0.04*0.04))) / (1 + x*x)
		if math.Abs(y*z) < 0.05 {
			depth.Data[i], mask.Data[i] = float32(z), 1
		}
	}
	return depth, mask
}

// fromTheSide is the pose of a second camera, at the right of the can, which sees the same as the first one.
var fromTheSide = Pose{Rotation: [3][3]float64{{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}, Translation: [3]float64{0.5, 0, 0.5}}

func TestTwoViews(t *testing.T) {
	depth, mask := seenCan()
	fitter := newFitter(t)
	for k, pose := range []Pose{Identity(), fromTheSide} {
		must(t, fitter.SelectView(k))
		must(t, fitter.SetIntrinsics(canCamera))
		must(t, fitter.SetPose(pose))
		must(t, fitter.PushDepth(depth, mask))
	}
	if count, err := fitter.ViewCount(); count != 2 || err != nil {
		t.Fatalf("%d views, %v", count, err)
	}
	wantStatus(t, fitter.SelectView(3), StatusInvalidArgument, "3")
	wantStatus(t, fitter.SetPose(Pose{}), StatusInvalidArgument, "rotation")
	counts, err := fitter.Counts()
	must(t, err)
	result, err := fitter.Fit()
	must(t, err)
	want := Cylinder{Point: [3]float64{0, 0, 0.5}, Direction: [3]float64{0, 1, 0}, Radius: 0.04}
	comparison, err := want.Compare(result.Cylinder)
	must(t, err)
	if math.Abs(comparison.RadiusRelative) > 1e-5 || comparison.AxisDistance > 1e-6 || comparison.Angle > 1e-5 {
		t.Errorf("%+v", comparison)
	}
	if counts.View != 1 || result.PointsUsed != 2*counts.PointsUsed {
		t.Errorf("%d points of all views, %+v", result.PointsUsed, counts)
	}
	residuals, err := fitter.Residuals(nil, ResidualPoints)
	must(t, err)
	weights, inliers, err := fitter.PointWeights()
	must(t, err)
	if n := int(counts.PointsUsed); len(residuals) != n || len(weights) != n || len(inliers) != n {
		t.Errorf("%d residuals, %d weights, %d inliers of %d points", len(residuals), len(weights), len(inliers), n)
	}
	for i, weight := range weights {
		if !(weight >= 0 && weight <= 1) || inliers[i] != (weight > 0) {
			t.Fatalf("weight %v, inlier %v", weight, inliers[i])
		}
	}
	parts, err := fitter.PointParts(nil)
	must(t, err)
	if len(parts) != len(weights) || parts[len(parts)/2] != PartBody || parts[len(parts)/2].String() != "body" {
		t.Errorf("%d parts, %v", len(parts), parts[len(parts)/2])
	}
	limbs, err := fitter.Limbs()
	must(t, err)
	if len(limbs) != 4 || limbs[3].View != 1 || limbs[3].Limb != 1 || limbs[3].Status != LimbNotSearched {
		t.Errorf("limbs %+v", limbs)
	}
	extent, err := fitter.Extent(nil, nil)
	must(t, err)
	if math.Abs(extent.Length-0.1) > 0.003 {
		t.Errorf("%+v", extent)
	}
	// What the second camera sees is in the reference frame, too.
	points, completion, err := Complete[float64](fitter, nil, nil, LayoutPacked)
	must(t, err)
	distances, err := result.Cylinder.Distances(Points[float64]{Data: points})
	must(t, err)
	for _, distance := range distances {
		if math.Abs(distance) > 1e-9 {
			t.Fatalf("a completed point is %v off the surface", distance)
		}
	}
	if completion.View != 1 || completion.Count == 0 {
		t.Errorf("%+v", completion)
	}
	must(t, fitter.Clear())
	if count, err := fitter.ViewCount(); count != 1 || err != nil {
		t.Errorf("%d views, %v", count, err)
	}
}

func TestViewsHaveCamerasOfTheirOwn(t *testing.T) {
	fitter := newFitter(t)
	depth, mask := seenCan()
	must(t, fitter.SetIntrinsics(canCamera))
	must(t, fitter.PushDepth(depth, mask))
	_, err := fitter.Fit()
	must(t, err)
	must(t, fitter.SelectView(1))
	must(t, fitter.SetIntrinsics(Intrinsics{Width: 8, Height: 6, FX: 7, FY: 7, CX: 3.5, CY: 2.5}))
	for k, size := range []int{160 * 120, 8 * 6} {
		must(t, fitter.SelectView(k))
		region := &Mask{Data: make([]uint8, size), Width: []int{160, 8}[k], Height: []int{120, 6}[k]}
		for i := range region.Data {
			region.Data[i] = 1
		}
		image, completion, err := CompleteDepth[float32](fitter, &Cylinder{[3]float64{0, 0, 0.5}, [3]float64{0, 1, 0}, 0.04}, region, 1)
		must(t, err)
		if len(image.Data) != size || completion.View != uint32(k) {
			t.Errorf("%d pixels, %+v", len(image.Data), completion)
		}
	}
}

func TestFrameOfTwoFitters(t *testing.T) {
	sample := loadFrame(t)
	alone := newFitter(t)
	must(t, alone.SetIntrinsics(sample.intrinsics))
	must(t, alone.PushDepth(sample.depth, &sample.mask))
	must(t, alone.PushImage(sample.grey))
	want, err := alone.Fit()
	must(t, err)

	frame, err := NewFrame()
	must(t, err)
	wantStatus(t, frame.SetDepth(sample.depth), StatusBadState, "")
	must(t, frame.SetIntrinsics(sample.intrinsics))
	must(t, frame.SetPose(Identity()))
	must(t, frame.SetDepth(sample.depth))
	must(t, frame.SetImage(sample.grey))
	// Two labels in one image; the second cylinder is that of the first one again.
	label := func(value uint8) *Mask {
		mask := sample.mask
		mask.Label = value
		mask.Data = make([]uint8, len(sample.mask.Data))
		for i, inside := range sample.mask.Data {
			if mask.Data[i] = 9; inside != 0 {
				mask.Data[i] = value
			}
		}
		return &mask
	}
	fitters := []*Fitter{newFitter(t), newFitter(t)}
	var group sync.WaitGroup
	for k := range fitters {
		k := k
		group.Add(1)
		go func() {
			defer group.Done()
			if err := fitters[k].UseFrame(frame, label(uint8(k+1))); err != nil {
				t.Error(err)
			}
		}()
	}
	group.Wait()
	wantStatus(t, fitters[0].UseFrame(frame, &Mask{Data: make([]uint8, 640*480), Width: 640, Height: 480}), StatusEmptyMask, "")
	must(t, frame.Close())
	must(t, frame.Close())
	if err := frame.SetPose(Identity()); err != ErrClosed {
		t.Error(err)
	}
	for _, fitter := range fitters {
		result, err := fitter.Fit()
		must(t, err)
		if result.Cylinder != want.Cylinder || result.LimbsLocated != 2 {
			t.Errorf("%v, not %v", result.Cylinder, want.Cylinder)
		}
		if image, _, err := CompleteDepth[float32](fitter, nil, nil, 1); err != nil || image.Width != 640 {
			t.Errorf("%d columns, %v", image.Width, err)
		}
	}
}

func TestDepthCamera(t *testing.T) {
	fitter := newFitter(t)
	depth, mask := seenCan()
	must(t, fitter.SetIntrinsics(canCamera))
	// A colour camera 30 mm to the right, whose mask is all that it sees.
	camera := DepthCamera{Intrinsics: canCamera, ToColour: Identity()}
	camera.ToColour.Translation[0] = -0.03
	must(t, fitter.SetDepthCamera(&camera))
	for i := range mask.Data {
		mask.Data[i] = 1
	}
	must(t, fitter.PushDepth(depth, mask))
	result, err := fitter.Fit()
	must(t, err)
	want := Cylinder{Point: [3]float64{-0.03, 0, 0.5}, Direction: [3]float64{0, 1, 0}, Radius: 0.04}
	comparison, err := want.Compare(result.Cylinder)
	must(t, err)
	if math.Abs(comparison.RadiusRelative) > 1e-4 || comparison.AxisDistance > 1e-5 {
		t.Errorf("%+v", comparison)
	}
	must(t, fitter.Clear())
	must(t, fitter.SetDepthCamera(nil))
	camera.Intrinsics.FX = -1
	wantStatus(t, fitter.SetDepthCamera(&camera), StatusInvalidIntrinsics, "fx")
}

func TestImagesInColour(t *testing.T) {
	frame, fitter := loadFrame(t), newFitter(t)
	must(t, fitter.SetIntrinsics(frame.intrinsics))
	must(t, fitter.PushDepth(frame.depth, &frame.mask))
	fit := func(image Image) Result {
		must(t, fitter.PushImage(image))
		result, err := fitter.Fit()
		must(t, err)
		if result.LimbsLocated != 2 {
			t.Errorf("%d limbs", result.LimbsLocated)
		}
		return result
	}
	grey := fit(frame.grey)
	width, height := frame.grey.Width, frame.grey.Height
	colours := func(order ColourOrder, channels, stride int, of ...int) ColourImage {
		image := ColourImage{Data: make([]uint8, width*height*stride), Order: order, Width: width, Height: height}
		if stride != channels {
			image.PixelStride = stride
		}
		for i := 0; i < width*height; i++ {
			value := int(frame.grey.Data[i/width*frame.grey.RowStride+i%width])
			for c, percent := range of {
				image.Data[i*stride+c] = uint8(value * percent / 100)
			}
		}
		return image
	}
	same := fit(colours(ColourBGR, 3, 3, 100, 100, 100))
	if math.Abs(same.Cylinder.Radius/grey.Cylinder.Radius-1) > 1e-6 {
		t.Errorf("radius %v in grey, %v in colours that are grey", grey.Cylinder.Radius, same.Cylinder.Radius)
	}
	bgr := fit(colours(ColourBGR, 3, 3, 20, 50, 100))
	for name, image := range map[string]ColourImage{
		"RGB": colours(ColourRGB, 3, 3, 100, 50, 20), "BGRA": colours(ColourBGRA, 4, 4, 20, 50, 100, 77),
		"RGBA": colours(ColourRGBA, 4, 4, 100, 50, 20, 0), "wide": colours(ColourRGB, 3, 5, 100, 50, 20, 1, 2),
	} {
		if other := fit(image); other.Cylinder != bgr.Cylinder {
			t.Errorf("%s: %v, not %v", name, other.Cylinder, bgr.Cylinder)
		}
	}
}

func TestClearInput(t *testing.T) {
	frame, fitter := loadFrame(t), newFitter(t)
	frame.push(t, fitter)
	fit := func() Result {
		t.Helper()
		result, err := fitter.Fit()
		must(t, err)
		return result
	}
	all := fit()
	must(t, fitter.ClearInput(InputImage))
	if result := fit(); result.LimbsLocated != 0 || result.SegmentsUsed != 2 {
		t.Errorf("%d limbs, %d segments", result.LimbsLocated, result.SegmentsUsed)
	}
	must(t, fitter.ClearInput(InputEdges))
	if result := fit(); result.SegmentsGiven != 0 || result.PointsUsed != all.PointsUsed {
		t.Errorf("%d segments, %d points", result.SegmentsGiven, result.PointsUsed)
	}
	must(t, fitter.ClearInput(InputPoints|InputDepth))
	_, err := fitter.Fit()
	wantStatus(t, err, StatusTooFewPoints, "")
	// The last result stays.
	_, err = fitter.Result()
	must(t, err)
	wantStatus(t, fitter.ClearInput(1<<20), StatusInvalidArgument, "")

	cloud := newFitter(t)
	must(t, cloud.PushPoints(Points[float64]{Data: pipe()}, nil))
	must(t, cloud.ClearInput(InputPoints|InputDepth))
	_, err = cloud.Fit()
	wantStatus(t, err, StatusTooFewPoints, "")
}

func TestManyReadersAtOnce(t *testing.T) {
	frame, fitter := loadFrame(t), newFitter(t)
	frame.push(t, fitter)
	want, err := fitter.Fit()
	must(t, err)
	var lines int64
	must(t, fitter.SetLog(LogDebug, func(LogLevel, string) { atomic.AddInt64(&lines, 1) }))
	var group sync.WaitGroup
	for k := 0; k < 8; k++ {
		k := k
		group.Add(1)
		go func() {
			defer group.Done()
			for round := 0; round < 5; round++ {
				result, err := fitter.Result()
				if err != nil || result.Covariance != want.Covariance {
					t.Error(err)
				}
				if extent, err := fitter.Extent(nil, nil); err != nil || !(extent.Length > 0) {
					t.Error(err)
				}
				if _, err := fitter.Residuals(nil, ResidualPoints); err != nil {
					t.Error(err)
				}
				if _, err := fitter.Limbs(); err != nil {
					t.Error(err)
				}
				if _, err := fitter.EndSamples(nil, nil); err != nil {
					t.Error(err)
				}
				// Each reads the message of its own failure.
				var failure *Error
				_, err = fitter.SelectEdges(frame.edges, nil, float64(-1000-k))
				if !errors.As(err, &failure) || failure.Status != StatusInvalidArgument {
					t.Error(err)
				} else if want := fmt.Sprint(-1000 - k); !containsWord(failure.Message, want) {
					t.Errorf("%q has no %s", failure.Message, want)
				}
			}
		}()
	}
	group.Wait()
	if lines < 40 {
		t.Errorf("%d lines of at least 40 failures", lines)
	}
}

func TestEachReaderHasThePanicOfItsOwnCallback(t *testing.T) {
	fitter := newFitter(t)
	must(t, fitter.SetLog(LogError, func(_ LogLevel, message string) { panic(message) }))
	var group sync.WaitGroup
	for k := 0; k < 8; k++ {
		k := k
		group.Add(1)
		go func() {
			defer group.Done()
			for round := 0; round < 50; round++ {
				func() {
					defer func() {
						message, _ := recover().(string)
						if want := fmt.Sprint(-1000 - k); !containsWord(message, want) {
							t.Errorf("%q has no %s", message, want)
						}
					}()
					_, _ = fitter.Evaluate(Cylinder{Direction: [3]float64{0, 1, 0}, Radius: float64(-1000 - k)})
				}()
			}
		}()
	}
	group.Wait()
}

func TestProjection(t *testing.T) {
	camera := canCamera
	camera.DistortionModel, camera.Distortion = DistortionBrownConrady, [8]float64{-0.2, 0.05, 0.001, -0.002}
	pixels := [][2]float64{{3, 4}, {79.5, 59.5}, {150, 100}, {math.NaN(), 0}}
	rays, err := camera.Unproject(pixels)
	must(t, err)
	xyz := make([]float64, 0, 12)
	for _, ray := range rays {
		xyz = append(xyz, 2*ray[0], 2*ray[1], 2*ray[2])
	}
	seen, err := camera.Project(Points[float64]{Data: xyz})
	must(t, err)
	for i, pixel := range pixels[:3] {
		if math.Abs(seen[i][0]-pixel[0]) > 1e-9 || math.Abs(seen[i][1]-pixel[1]) > 1e-9 || rays[i][2] != 1 {
			t.Errorf("%v comes back as %v, its ray is %v", pixel, seen[i], rays[i])
		}
	}
	if !math.IsNaN(rays[3][0]) || !math.IsNaN(seen[3][1]) {
		t.Errorf("%v, %v", rays[3], seen[3])
	}
	if none, err := camera.Unproject(nil); len(none) != 0 || err != nil {
		t.Errorf("%v, %v", none, err)
	}
	_, err = Intrinsics{}.Project(Points[float32]{})
	wantStatus(t, err, StatusInvalidIntrinsics, "")
}

func TestStatedIndependentPoints(t *testing.T) {
	fitter := newFitter(t)
	must(t, fitter.PushPoints(Points[float64]{Data: pipe()}, nil))
	options := DefaultOptions()
	options.IndependentPoints = 40
	must(t, fitter.SetOptions(options))
	result, err := fitter.Fit()
	must(t, err)
	if result.IndependentPoints != 40 || !(result.RadiusDeviation > 0) {
		t.Errorf("%v independent points, deviation %v", result.IndependentPoints, result.RadiusDeviation)
	}
}

// containsWord says whether a text has a number as a whole, not as the beginning of a longer one.
func containsWord(text, number string) bool {
	return regexp.MustCompile(regexp.QuoteMeta(number) + `\b`).MatchString(text)
}

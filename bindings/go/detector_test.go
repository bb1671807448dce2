package cylfuse

import (
	"errors"
	"math"
	"testing"
)

// Two cylinders before a wall.

var (
	pairCamera = Intrinsics{Width: 160, Height: 120, FX: 170, FY: 170, CX: 79.5, CY: 59.5}
	pairTruths = [2]Cylinder{
		{[3]float64{-0.12, 0, 0.7}, [3]float64{0.1, 0.99, 0.1}, 0.05},
		{[3]float64{0.13, 0.05, 0.8}, [3]float64{0.9, 0.3, 0.2}, 0.035},
	}
	pairLengths = [2]float64{0.24, 0.2}
)

const pairPixels = 160 * 120

// pair is what a camera sees of the scene, the same as a cloud, and who is seen where: 0 the wall.
type pair struct {
	depth  DepthImage[float32]
	image  GreyImage[uint8]
	points Points[float64]
	owners []int
}

func dot(a, b [3]float64) float64 { return a[0]*b[0] + a[1]*b[1] + a[2]*b[2] }

// seen is the depth at a place of the image, and who is there.
func seen(column, row float64) (depth float64, owner int) {
	ray := [3]float64{(column - pairCamera.CX) / pairCamera.FX, (row - pairCamera.CY) / pairCamera.FY, 1}
	depth = 1.2 / (1 + 0.1*ray[0] - 0.2*ray[1])
	for k, truth := range pairTruths {
		norm := math.Sqrt(dot(truth.Direction, truth.Direction))
		along, middle := dot(ray, truth.Direction)/norm, dot(truth.Point, truth.Direction)/norm
		var across, offset [3]float64
		for i := range ray {
			across[i] = ray[i] - along*truth.Direction[i]/norm
			offset[i] = truth.Point[i] - middle*truth.Direction[i]/norm
		}
		a, b := dot(across, across), dot(across, offset)
		z := (b - math.Sqrt(b*b-a*(dot(offset, offset)-truth.Radius*truth.Radius))) / a
		if math.Abs(z*along-middle) <= pairLengths[k]/2 && z < depth {
			depth, owner = z, k+1
		}
	}
	return depth, owner
}

var thePair = makePair()

func makePair() pair {
	width, height := pairCamera.Width, pairCamera.Height
	made := pair{
		DepthImage[float32]{Data: make([]float32, pairPixels), Width: width, Height: height, Scale: 1},
		GreyImage[uint8]{Data: make([]uint8, pairPixels), Width: width, Height: height},
		Points[float64]{Data: make([]float64, 0, 3*pairPixels), Width: width, Height: height},
		make([]int, pairPixels),
	}
	state := uint32(1)
	for k := range made.owners {
		column, row := float64(k%width), float64(k/width)
		z, owner := seen(column, row)
		made.owners[k], made.image.Data[k] = owner, 40
		for ray := 0; ray < 16; ray++ {
			if _, owner := seen(column+(float64(ray%4)-1.5)/4, row+(float64(ray/4)-1.5)/4); owner > 0 {
				made.image.Data[k] += 10
			}
		}
		// Errors of up to 1 mm, evenly spread.
		state = state*1664525 + 1013904223
		z += 0.001 * (float64(state)/2147483648 - 1)
		made.depth.Data[k] = float32(z)
		made.points.Data = append(made.points.Data, z*(column-pairCamera.CX)/pairCamera.FX, z*(row-pairCamera.CY)/pairCamera.FY, z)
	}
	return made
}

func newDetector(t testing.TB) *Detector {
	t.Helper()
	detector, err := NewDetector()
	must(t, err)
	t.Cleanup(func() {
		if err := detector.Close(); err != nil {
			t.Error(err)
		}
	})
	return detector
}

func pairFrame(t testing.TB, withImage bool) *Frame {
	t.Helper()
	frame, err := NewFrame()
	must(t, err)
	t.Cleanup(func() { frame.Close() })
	must(t, frame.SetIntrinsics(pairCamera))
	must(t, frame.SetDepth(thePair.depth))
	if withImage {
		must(t, frame.SetImage(thePair.image))
	}
	return frame
}

func TestASearchThatWasCutShortSaysSo(t *testing.T) {
	// Bumps in both directions, 12 pixels apart: more to look at than a search may.
	bumps := DepthImage[float32]{Data: make([]float32, 640*480), Width: 640, Height: 480, Scale: 1}
	for k := range bumps.Data {
		wave := func(k int) float64 { return math.Sin(math.Pi / 6 * float64(k)) }
		bumps.Data[k] = float32(1 + 1.2/525*wave(k%640)*wave(k/640))
	}
	frame, err := NewFrame()
	must(t, err)
	defer frame.Close()
	must(t, frame.SetIntrinsics(Intrinsics{Width: 640, Height: 480, FX: 525, FY: 525, CX: 319.5, CY: 239.5}))
	must(t, frame.SetDepth(bumps))
	detector := newDetector(t)
	if _, err := detector.IsComplete(); !errors.Is(err, StatusBadState) {
		t.Error(err)
	}
	for frame, expected := range map[*Frame]bool{frame: false, pairFrame(t, true): true} {
		_, err := detector.Detect(frame)
		must(t, err)
		complete, err := detector.IsComplete()
		must(t, err)
		if complete != expected {
			t.Errorf("complete: %v, not %v", complete, expected)
		}
		columns, rows, err := detector.DepthMoved()
		must(t, err)
		if columns != 0 || rows != 0 {
			t.Errorf("moved by %d, %d", columns, rows)
		}
	}
}

// checkScene checks what a detector says of both cylinders, and one thing against another.
func checkScene(t *testing.T, detector *Detector, found []Detection, tolerance float64) {
	t.Helper()
	labels, err := detector.Labels()
	must(t, err)
	if len(found) != 2 || len(labels.Data) != pairPixels {
		t.Fatalf("%d cylinders, %d labels", len(found), len(labels.Data))
	}
	if found[0].Score < found[1].Score || found[1].Score < 0.5 || found[0].Score > 1 {
		t.Errorf("scores %v and %v", found[0].Score, found[1].Score)
	}
	both, labelled := 0, uint64(0)
	for index, one := range found {
		truth := -1
		for k, cylinder := range pairTruths {
			difference, err := cylinder.Compare(one.Result.Cylinder)
			must(t, err)
			if difference.Angle < tolerance && difference.AxisDistance < tolerance*cylinder.Radius &&
				math.Abs(difference.RadiusRelative) < tolerance {
				truth = k
			}
		}
		if truth < 0 {
			t.Fatalf("%v is none of them", one.Result.Cylinder)
		}
		both |= 1 << truth
		indices, err := detector.Indices(index)
		must(t, err)
		own := 0
		for k, place := range indices {
			if labels.Data[place] != uint16(index+1) || k > 0 && place <= indices[k-1] {
				t.Fatalf("place %d of cylinder %d", place, index)
			}
			if thePair.owners[place] == truth+1 {
				own++
			}
		}
		if uint64(len(indices)) != one.Pixels || one.Pixels < 300 || float64(own) < 0.95*float64(len(indices)) {
			t.Errorf("%d indices of %d pixels, %d its own", len(indices), one.Pixels, own)
		}
		if one.Result.StartKind != StartModel || one.Result.RadiusDeviation <= 0 || one.Result.PointsUsed > one.Pixels {
			t.Errorf("%+v", one.Result)
		}
		if one.Extent != nil && math.Abs(one.Extent.Length-pairLengths[truth]) > 0.05*pairLengths[truth] {
			t.Errorf("length %v", one.Extent.Length)
		}
		labelled += one.Pixels
	}
	for _, label := range labels.Data {
		if label != 0 {
			labelled--
		}
	}
	if both != 3 || labelled != 0 {
		t.Errorf("cylinders %d, %d labels too few", both, labelled)
	}
}

// sameScene compares all but the times, and NaN with NaN.
func sameScene(t testing.TB, a, b []Detection) {
	t.Helper()
	if len(a) != len(b) {
		t.Fatalf("%d and %d cylinders", len(a), len(b))
	}
	for k := range a {
		if a[k].Score != b[k].Score || a[k].Pixels != b[k].Pixels || a[k].Result.Cylinder != b[k].Result.Cylinder ||
			a[k].Result.Covariance != b[k].Result.Covariance || (a[k].Extent == nil) != (b[k].Extent == nil) ||
			a[k].Extent != nil && a[k].Extent.Start != b[k].Extent.Start {
			t.Errorf("%+v is not %+v", a[k], b[k])
		}
	}
}

func TestCylindersOfAFrame(t *testing.T) {
	detector, frame, without := newDetector(t), pairFrame(t, true), pairFrame(t, false)
	found, err := detector.Detect(frame)
	must(t, err)
	checkScene(t, detector, found, 0.01)
	if found[0].Result.LimbsLocated != 2 || found[0].Extent == nil {
		t.Errorf("%+v", found[0])
	}
	again, err := detector.Detections()
	must(t, err)
	sameScene(t, found, again)

	// The image is not looked at: as if there were none.
	options := DefaultDetectorOptions()
	options.ImageUse = ImageUseIgnore
	must(t, detector.SetOptions(options))
	ignored, err := detector.Detect(frame)
	must(t, err)
	checkScene(t, detector, ignored, 0.1)
	must(t, detector.SetOptions(DefaultDetectorOptions()))
	missing, err := detector.Detect(without)
	must(t, err)
	sameScene(t, ignored, missing)

	// In the reference frame.
	pose := Pose{[3][3]float64{{0.8, 0, 0.6}, {0, 1, 0}, {-0.6, 0, 0.8}}, [3]float64{-0.5, 0.1, 0.2}}
	must(t, without.SetPose(pose))
	turned, err := detector.Detect(without)
	must(t, err)
	for k, one := range missing {
		there := one.Result.Cylinder
		for i, row := range pose.Rotation {
			there.Point[i] = pose.Translation[i] + dot(row, one.Result.Cylinder.Point)
			there.Direction[i] = dot(row, one.Result.Cylinder.Direction)
		}
		difference, err := there.Compare(turned[k].Result.Cylinder)
		must(t, err)
		if difference.Angle > 1e-9 || difference.AxisDistance > 1e-9 || math.Abs(difference.RadiusRelative) > 1e-9 {
			t.Errorf("%+v", difference)
		}
	}
	must(t, frame.Close())
	must(t, without.Close())
	labels, err := detector.Labels()
	must(t, err)
	if labels.Width != 160 || labels.Height != 120 {
		t.Errorf("%d x %d labels", labels.Width, labels.Height)
	}
}

func TestCylindersOfACloud(t *testing.T) {
	detector := newDetector(t)
	found, err := detector.DetectPoints(thePair.points)
	must(t, err)
	checkScene(t, detector, found, 0.1)
	if found[0].Extent == nil || found[0].Extent.EndSource != EndFromPoints {
		t.Errorf("ends of a cloud: %+v", found[0].Extent)
	}

	// Not organised, float, one after the other with other things between them, and weights.
	mixed := make([]float32, 6*pairPixels)
	for k := 0; k < pairPixels; k++ {
		for i := 0; i < 3; i++ {
			mixed[6*k+i] = float32(thePair.points.Data[3*k+i])
		}
		mixed[6*k+3] = 1
	}
	cloud := Points[float32]{Data: mixed, Width: pairPixels, PointStride: 6, Weights: mixed[3:], WeightStride: 6}
	found, err = detector.DetectPoints(cloud)
	must(t, err)
	checkScene(t, detector, found, 0.1)
	// Weights of 0 leave points out: all but those of the wall and the first cylinder.
	for k, owner := range thePair.owners {
		if owner == 2 {
			mixed[6*k+3] = 0
		}
	}
	found, err = detector.DetectPoints(cloud)
	must(t, err)
	if len(found) != 1 {
		t.Errorf("%d cylinders", len(found))
	}
	mixed[6*7+3] = -1
	_, err = detector.DetectPoints(cloud)
	wantStatus(t, err, StatusInvalidArgument, "the weight of point 7 is -1")
	if found, err = detector.Detections(); err != nil || len(found) != 1 {
		t.Errorf("%d cylinders, %v", len(found), err)
	}
}

func TestFitterOfADetection(t *testing.T) {
	detector, frame := newDetector(t), pairFrame(t, true)
	found, err := detector.Detect(frame)
	must(t, err)
	fitter, err := detector.Fitter(1)
	must(t, err)
	defer fitter.Close()
	must(t, detector.Close())
	must(t, frame.Close())
	result, err := fitter.Result()
	must(t, err)
	extent, err := fitter.Extent(nil, nil)
	must(t, err)
	if result.Covariance != found[1].Result.Covariance || extent != *found[1].Extent {
		t.Errorf("%+v, %+v", result, extent)
	}
	limbs, err := fitter.Limbs()
	must(t, err)
	if limbs[0].Status != LimbLocated || limbs[1].Status != LimbLocated {
		t.Errorf("%+v", limbs)
	}
	image, _, err := CompleteDepth[float32](fitter, nil, nil, 1)
	must(t, err)
	residuals, err := fitter.Residuals(nil, ResidualPoints)
	must(t, err)
	if image.Width != 160 || uint64(len(residuals)) != result.PointsUsed {
		t.Errorf("%d columns, %d residuals", image.Width, len(residuals))
	}
	// The same fit once more.
	again, err := fitter.Fit()
	must(t, err)
	if again.Cylinder != result.Cylinder {
		t.Errorf("%v is not %v", again.Cylinder, result.Cylinder)
	}

	other := newDetector(t)
	found, err = other.DetectPoints(thePair.points)
	must(t, err)
	ofPoints, err := other.Fitter(0)
	must(t, err)
	defer ofPoints.Close()
	counts, err := ofPoints.Counts()
	must(t, err)
	// Fitted to its whole region: its points share no errors.
	if counts.PointsUsed != found[0].Pixels {
		t.Errorf("%d points of %d", counts.PointsUsed, found[0].Pixels)
	}
	_, err = other.Fitter(2)
	wantStatus(t, err, StatusInvalidArgument, "index is 2; it must be less than the number of cylinders, 2")
	_, err = other.Indices(2)
	wantStatus(t, err, StatusInvalidArgument, "index is 2")
	if _, err = other.Indices(-1); !errors.Is(err, ErrShape) {
		t.Error(err)
	}
	if _, err = other.Fitter(-1); !errors.Is(err, ErrShape) {
		t.Error(err)
	}
}

func TestLimitsOfADetector(t *testing.T) {
	detector, frame := newDetector(t), pairFrame(t, true)
	options := DetectorOptions{ImageUseAuto, 1, 0, 100, 0.5, 0.04, 0.06, [3]float64{0, -3, 0}, 0.2}
	must(t, detector.SetOptions(options))
	if read, err := detector.Options(); err != nil || read != options {
		t.Errorf("%+v, %v", read, err)
	}
	for cloud := 0; cloud < 2; cloud++ {
		found, err := detector.Detect(frame)
		if cloud == 1 {
			found, err = detector.DetectPoints(thePair.points)
		}
		must(t, err)
		if len(found) != 1 || math.Abs(found[0].Result.Cylinder.Radius-0.05) > 0.005 {
			t.Errorf("%+v", found)
		}
	}
	options = DefaultDetectorOptions()
	options.MinPixels = math.MaxUint64
	must(t, detector.SetOptions(options))
	if found, err := detector.Detect(frame); err != nil || len(found) != 0 {
		t.Errorf("%+v, %v", found, err)
	}
	bad := options
	bad.MinScore = 1.5
	wantStatus(t, detector.SetOptions(bad), StatusInvalidArgument, "options.min_score is 1.5")
	if read, err := detector.Options(); err != nil || read != options {
		t.Errorf("%+v, %v", read, err)
	}
	fits := DefaultOptions()
	fits.DepthNoise = 0.001
	must(t, detector.SetFitOptions(fits))
	refused := fits
	refused.Start = StartMoments
	wantStatus(t, detector.SetFitOptions(refused), StatusInvalidArgument, "of the fits")
	if read, err := detector.FitOptions(); err != nil || read != fits {
		t.Errorf("%+v, %v", read, err)
	}
	fits.Objective = ObjectivePaper
	must(t, detector.SetFitOptions(fits))
	must(t, detector.SetOptions(DefaultDetectorOptions()))
	_, err := detector.Detect(frame)
	wantStatus(t, err, StatusUnsupported, "")
}

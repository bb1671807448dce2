package cylfuse

import (
	"bytes"
	"encoding/json"
	"errors"
	"image"
	_ "image/png"
	"math"
	"os"
	"path/filepath"
	"strings"
	"sync"
	"testing"
)

// pipe is a quarter of a pipe of radius 0.5 along y, 200 points.
func pipe() []float64 {
	var xyz []float64
	for k := 0.0; k < 200; k++ {
		xyz = append(xyz, 0.5*math.Cos(0.008*k), 0.1*math.Mod(k, 7), 2-0.5*math.Sin(0.008*k))
	}
	return xyz
}

func newFitter(t testing.TB) *Fitter {
	t.Helper()
	fitter, err := NewFitter()
	if err != nil {
		t.Fatal(err)
	}
	t.Cleanup(func() {
		if err := fitter.Close(); err != nil {
			t.Error(err)
		}
	})
	return fitter
}

// must ends the test at an error.
func must(t testing.TB, err error) {
	t.Helper()
	if err != nil {
		t.Fatal(err)
	}
}

func wantStatus(t testing.TB, err error, status Status, message string) {
	t.Helper()
	var failure *Error
	if !errors.Is(err, status) || !errors.As(err, &failure) || !strings.Contains(failure.Message, message) {
		t.Fatalf("%v is not %q with %q", err, status, message)
	}
}

// frame is one of the sample frames of the repository.
type frame struct {
	intrinsics Intrinsics
	depth      DepthImage[uint16]
	mask       Mask
	grey       GreyImage[uint8]
	edges      Segments[float64]
}

func loadFrame(t testing.TB) frame {
	folder := filepath.Join("..", "..", "tests", "data", "frames", "w004")
	text, err := os.ReadFile(filepath.Join(folder, "frame.json"))
	must(t, err)
	var description struct {
		Camera struct {
			Width, Height  int
			FX, FY, CX, CY float64
			Distortion     []float64
		}
		DepthScale float64 `json:"depth_scale"`
		Edges      [][2][2]float64
	}
	must(t, json.Unmarshal(text, &description))
	camera := description.Camera
	intrinsics := Intrinsics{Width: camera.Width, Height: camera.Height, FX: camera.FX, FY: camera.FY, CX: camera.CX,
		CY: camera.CY, DistortionModel: DistortionBrownConrady}
	copy(intrinsics.Distortion[:], camera.Distortion)
	width, height := camera.Width, camera.Height

	picture := func(name string) image.Image {
		data, err := os.ReadFile(filepath.Join(folder, name))
		must(t, err)
		decoded, _, err := image.Decode(bytes.NewReader(data))
		must(t, err)
		return decoded
	}
	depth := make([]uint16, width*height)
	for i, stored := 0, picture("depth.png").(*image.Gray16); i < len(depth); i++ {
		depth[i] = stored.Gray16At(i%width, i/width).Y
	}
	mask, grey := picture("mask.png").(*image.Gray), picture("image.png").(*image.Gray)
	var edges []float64
	for _, edge := range description.Edges {
		edges = append(edges, edge[0][0], edge[0][1], edge[1][0], edge[1][1])
	}
	return frame{
		intrinsics,
		DepthImage[uint16]{Data: depth, Width: width, Height: height, Scale: description.DepthScale},
		Mask{Data: mask.Pix, Width: width, Height: height, RowStride: mask.Stride},
		GreyImage[uint8]{Data: grey.Pix, Width: width, Height: height, RowStride: grey.Stride},
		Segments[float64]{Data: edges},
	}
}

func (frame *frame) push(t testing.TB, fitter *Fitter) {
	t.Helper()
	must(t, fitter.SetIntrinsics(frame.intrinsics))
	must(t, fitter.PushDepth(frame.depth, &frame.mask))
	must(t, fitter.PushImage(frame.grey))
	must(t, fitter.PushEdges(frame.edges))
}

func TestPointsOfEitherTypeAndAnyStride(t *testing.T) {
	xyz := pipe()
	packed, err := FitPoints(xyz)
	must(t, err)
	if math.Abs(packed.Cylinder.Radius-0.5) > 1e-9 || packed.Flags != 0 || packed.PointsUsed != 200 {
		t.Fatalf("radius %v, warnings %v, %d points", packed.Cylinder.Radius, packed.Flags, packed.PointsUsed)
	}
	single := make([]float32, len(xyz))
	padded := make([]float64, 0, 5*200)
	weights := make([]float64, 200)
	for k := range weights {
		weights[k] = 1
		padded = append(padded, xyz[3*k], xyz[3*k+1], xyz[3*k+2], math.NaN(), 7)
	}
	for i, value := range xyz {
		single[i] = float32(value)
	}
	fromSingle, err := FitPoints(single)
	must(t, err)
	if difference := math.Abs(fromSingle.Cylinder.Radius - 0.5); difference > 1e-6 || difference == 0 {
		t.Fatalf("radius from float32 is off by %v", difference)
	}
	fitter := newFitter(t)
	must(t, fitter.PushPoints(Points[float64]{Data: padded, PointStride: 5, Weights: weights}, nil))
	strided, err := fitter.Fit()
	must(t, err)
	if strided.Cylinder != packed.Cylinder {
		t.Fatalf("%v strided, %v packed", strided.Cylinder, packed.Cylinder)
	}
	// The last point may end with its own numbers.
	must(t, fitter.Clear())
	must(t, fitter.PushPoints(Points[float64]{Data: padded[:5*199+3], PointStride: 5}, nil))
	counts, err := fitter.Counts()
	must(t, err)
	if counts.PointsUsed != 200 {
		t.Fatalf("%d points", counts.PointsUsed)
	}
}

func TestFrame(t *testing.T) {
	frame, fitter := loadFrame(t), newFitter(t)
	must(t, fitter.Reserve(20000, 2))
	frame.push(t, fitter)
	result, err := fitter.Fit()
	must(t, err)
	// The pipe of this frame has r = 57.0 mm (tests/data/README.md).
	if math.Abs(result.Cylinder.Radius-0.057) > 0.001 || result.SegmentsUsed != 2 || result.LimbsLocated != 2 {
		t.Fatalf("radius %v by %d segments, %d limbs", result.Cylinder.Radius, result.SegmentsUsed, result.LimbsLocated)
	}
	if deviation := math.Sqrt(result.Covariance[6][6]); math.Abs(deviation/result.RadiusDeviation-1) > 1e-9 {
		t.Errorf("deviation %v, root of the covariance %v", result.RadiusDeviation, deviation)
	}
	again, err := fitter.Result()
	must(t, err)
	if again.Cylinder != result.Cylinder || again.Covariance != result.Covariance {
		t.Error("the kept result differs")
	}
	evaluated, err := fitter.Evaluate(result.Cylinder)
	must(t, err)
	if math.Abs(evaluated.EnergyPoints/result.EnergyPoints-1) > 1e-6 {
		t.Errorf("energy %v evaluated, %v fitted", evaluated.EnergyPoints, result.EnergyPoints)
	}
	residuals, err := fitter.Residuals(nil, ResidualPoints)
	must(t, err)
	squares := 0.0
	for _, residual := range residuals {
		squares += residual * residual
	}
	if uint64(len(residuals)) != result.PointsUsed || math.Abs(math.Sqrt(squares/float64(len(residuals)))/result.PointRMS-1) > 1e-9 {
		t.Errorf("%d residuals for %d points", len(residuals), result.PointsUsed)
	}
	if edges, err := fitter.Residuals(&result.Cylinder, ResidualEdges); err != nil || len(edges) != 4 {
		t.Errorf("%d residuals of edges, %v", len(edges), err)
	}
	samples, err := fitter.LimbSamples()
	must(t, err)
	if len(samples) < 8 || samples[0].Deviation <= 0 {
		t.Errorf("%d samples", len(samples))
	}
	diagnosis, err := fitter.Diagnose(nil)
	must(t, err)
	if ratio := diagnosis.SingularValues[0] / diagnosis.SingularValues[4]; diagnosis.Rank != 5 || math.Abs(ratio/diagnosis.Condition-1) > 1e-9 {
		t.Errorf("rank %d, condition %v", diagnosis.Rank, diagnosis.Condition)
	}

	// The given edges lie on the limbs; a line across the image lies on none.
	found := Segments[float64]{Data: append([]float64{10, 10, 600, 30}, frame.edges.Data...)}
	limbs, err := fitter.SelectEdges(found, nil, 0)
	must(t, err)
	if len(limbs) != 3 || limbs[0] != 0 || limbs[1]+limbs[2] != 3 || limbs[1] == limbs[2] {
		t.Errorf("edges on the limbs %v", limbs)
	}
	_, err = fitter.SelectEdges(found, nil, -1)
	wantStatus(t, err, StatusInvalidArgument, "-1")

	extent, err := fitter.Extent(nil, nil)
	must(t, err)
	along := 0.0
	for i, direction := range result.Cylinder.Direction {
		along += direction * (extent.End[i] - extent.Start[i])
	}
	if math.Abs(along-extent.Length) > 1e-9 || !(extent.Length > 0.05) {
		t.Errorf("length %v, ends %v apart", extent.Length, along)
	}

	points, completion, err := Complete[float64](fitter, nil, nil, LayoutPacked)
	must(t, err)
	if uint64(len(points)) != 3*completion.Count || completion.Count != completion.Hits {
		t.Fatalf("%d numbers, %+v", len(points), completion)
	}
	distances, err := result.Cylinder.Distances(Points[float64]{Data: points})
	must(t, err)
	for _, distance := range distances {
		if math.Abs(distance) > 1e-9 {
			t.Fatalf("a completed point is %v off the surface", distance)
		}
	}
	organised, _, err := Complete[float32](fitter, &result.Cylinder, &frame.mask, LayoutOrganised)
	must(t, err)
	if len(organised) != 3*640*480 || organised[0] == organised[0] {
		t.Errorf("%d numbers, the first is %v", len(organised), organised[0])
	}
	image, completion, err := CompleteDepth[uint16](fitter, nil, nil, 0.0001)
	must(t, err)
	written := uint64(0)
	for _, depth := range image.Data {
		if depth != 0 {
			written++
		}
	}
	if written != completion.Count || image.Width != 640 || image.Height != 480 {
		t.Errorf("%d pixels, %+v", written, completion)
	}
}

func TestOptionsComeBack(t *testing.T) {
	options := Options{
		Method: MethodRANSAC, Objective: ObjectivePaper, Start: StartMoments, NearWall: NearWallOff, Chart: ChartLocal,
		EdgeUse: EdgeUseAsGiven, ExtentRule: ExtentRuleExtremes, MaxIterations: 7, MaxThreads: 2, EdgeWeight: 0.25,
		InitialLambda: 0.5, LambdaFactor: 3, MaxLambda: 1e6, CostTolerance: 1e-9, GradientTolerance: 1e-8, StepTolerance: 1e-7,
		IndependentPoints: 50, DepthNoise: 0.001, ImageNoise: 2, EdgeNoise: 0.75, MaskNoise: 1.25, ImageBlur: 0.9,
		DrawnPixel: 1.5, DepthShared: 0.004, RANSACThreshold: 0.125, Seed: 1<<63 + 5,
		RANSACMaxIterations: 77, RadiusMin: 0.01, RadiusMax: 0.75, Axis: [3]float64{0, 1, 0}, AxisMaxAngle: 0.3,
	}
	fitter := newFitter(t)
	must(t, fitter.SetOptions(options))
	got, err := fitter.Options()
	must(t, err)
	if got != options {
		t.Errorf("%+v\n%+v", got, options)
	}
	if defaults := DefaultOptions(); defaults.EdgeWeight != 0.6 || defaults.MaxIterations != 400 || defaults.MaxThreads != 1 {
		t.Errorf("%+v", defaults)
	}
}

func TestFailures(t *testing.T) {
	fitter := newFitter(t)
	if _, err := FitPoints([]float64{0, 0, 1, 0, 1, 1}); !errors.Is(err, StatusTooFewPoints) {
		t.Error(err)
	}
	options := DefaultOptions()
	options.EdgeWeight = 2
	wantStatus(t, fitter.SetOptions(options), StatusInvalidArgument, "options.edge_weight is 2; it must lie in [0, 1]")
	wantStatus(t, fitter.SetIntrinsics(Intrinsics{Width: 4, Height: 4, FX: math.NaN(), FY: 1}), StatusInvalidIntrinsics, "fx")
	wantStatus(t, fitter.PushDepth(DepthImage[uint16]{Data: make([]uint16, 4), Width: 2, Height: 2, Scale: 1}, nil), StatusBadState, "")
	must(t, fitter.SetIntrinsics(Intrinsics{Width: 2, Height: 2, FX: 1, FY: 1}))
	wantStatus(t, fitter.PushDepth(DepthImage[uint16]{Data: make([]uint16, 4), Width: 2, Height: 2}, nil), StatusInvalidArgument, "depth scale is 0")
	_, err := fitter.Result()
	wantStatus(t, err, StatusBadState, "")
	_, _, err = CompleteDepth[float32](fitter, nil, nil, 1)
	wantStatus(t, err, StatusBadState, "")
	_, err = Cylinder{}.Compare(Cylinder{})
	wantStatus(t, err, StatusInvalidArgument, "axis direction is ")
	if StatusNoDepth.Error()[:9] != "NO_DEPTH:" {
		t.Error(StatusNoDepth)
	}
}

func TestGeometry(t *testing.T) {
	cylinder := Cylinder{Point: [3]float64{0, 0, 2}, Direction: [3]float64{0, 2, 0}, Radius: 0.5}
	lines, err := cylinder.Project(Intrinsics{Width: 100, Height: 100, FX: 100, FY: 100, CX: 50, CY: 50})
	must(t, err)
	// The limbs stand at the angle asin(r / distance) from the middle.
	for i, side := range []float64{-1, 1} {
		u := -lines[i][2] / lines[i][0]
		if want := 50 + side*100*math.Tan(math.Asin(0.25)); math.Abs(u-want) > 1e-9 && math.Abs(u-(100-want)) > 1e-9 {
			t.Errorf("line %d at %v, not %v", i, u, want)
		}
	}
	other := Cylinder{Point: [3]float64{0.25, 0, 2}, Direction: [3]float64{0, 1, 0}, Radius: 0.25}
	comparison, err := cylinder.Compare(other)
	must(t, err)
	if comparison != (Comparison{0, 0.25, -0.5}) {
		t.Errorf("%+v", comparison)
	}
}

func TestCallbacks(t *testing.T) {
	fitter := newFitter(t)
	must(t, fitter.PushPoints(Points[float64]{Data: pipe()}, nil))
	var lines []string
	must(t, fitter.SetLog(LogInfo, func(level LogLevel, message string) {
		if level == LogOff || level > LogInfo {
			t.Errorf("level %d", level)
		}
		lines = append(lines, message)
	}))
	solves := 0
	must(t, fitter.SetProgress(func(progress Progress) bool {
		if progress.Phase == PhaseSolve {
			solves++
			if _, err := fitter.Counts(); !errors.Is(err, StatusBusy) {
				t.Errorf("a call from the callback: %v", err)
			}
			if err := fitter.Close(); !errors.Is(err, StatusBusy) {
				t.Errorf("closed from the callback: %v", err)
			}
		}
		return true
	}))
	result, err := fitter.Fit()
	must(t, err)
	if solves == 0 || len(lines) == 0 {
		t.Fatalf("%d solves heard, %d lines", solves, len(lines))
	}

	must(t, fitter.SetProgress(func(Progress) bool { return false }))
	_, err = fitter.Fit()
	wantStatus(t, err, StatusCancelled, "")
	must(t, fitter.SetProgress(func(Progress) bool { return fitter.Cancel() == nil }))
	_, err = fitter.Fit()
	wantStatus(t, err, StatusCancelled, "")
	// Between calls there is nothing to cancel.
	must(t, fitter.SetProgress(nil))
	must(t, fitter.Cancel())
	_, err = fitter.Fit()
	must(t, err)

	// A panic of a callback reaches the caller of Fit, and the fitter stays usable.
	must(t, fitter.SetProgress(func(Progress) bool { panic("of the caller") }))
	func() {
		defer func() {
			if thrown := recover(); thrown != "of the caller" {
				t.Errorf("%v", thrown)
			}
		}()
		fitter.Fit()
	}()
	must(t, fitter.SetProgress(nil))
	must(t, fitter.SetLog(LogOff, nil))
	must(t, fitter.Clear())
	must(t, fitter.PushPoints(Points[float64]{Data: pipe()}, nil))
	again, err := fitter.Fit()
	must(t, err)
	if again.Cylinder != result.Cylinder {
		t.Error("another result after a panic")
	}
}

func TestEightFittersAtOnce(t *testing.T) {
	frame := loadFrame(t)
	var group sync.WaitGroup
	cylinders := make([]Cylinder, 8)
	for k := range cylinders {
		k, fitter := k, newFitter(t)
		frame.push(t, fitter)
		group.Add(1)
		go func() {
			defer group.Done()
			for round := 0; round < 3; round++ {
				result, err := fitter.Fit()
				if err != nil {
					t.Error(err)
				}
				cylinders[k] = result.Cylinder
			}
		}()
	}
	group.Wait()
	for _, cylinder := range cylinders {
		if cylinder != cylinders[0] || cylinder.Radius == 0 {
			t.Fatalf("%v and %v", cylinder, cylinders[0])
		}
	}
}

func TestLibrary(t *testing.T) {
	if !strings.HasPrefix(BuildInfo(), "cylfuse "+Version()) && !strings.Contains(BuildInfo(), Version()) {
		t.Errorf("%q, %q", Version(), BuildInfo())
	}
}

func TestListingIsNoErrorForTheLog(t *testing.T) {
	frame, fitter := loadFrame(t), newFitter(t)
	frame.push(t, fitter)
	_, err := fitter.Fit()
	must(t, err)
	must(t, fitter.SetLog(LogError, func(_ LogLevel, message string) { t.Error(message) }))
	for _, kind := range []ResidualKind{ResidualPoints, ResidualEdges} {
		residuals, err := fitter.Residuals(nil, kind)
		must(t, err)
		if len(residuals) == 0 {
			t.Errorf("no residuals of %v", kind)
		}
	}
	samples, err := fitter.LimbSamples()
	must(t, err)
	if len(samples) == 0 {
		t.Errorf("%d samples", len(samples))
	}
}

func TestNames(t *testing.T) {
	for got, want := range map[string]string{
		StartRANSAC.String():                                   "RANSAC",
		TerminationRadiusRanAway.String():                      "radius ran away",
		EndHidden.String():                                     "hidden",
		PhaseSolve.String():                                    "solve",
		LogDebug.String():                                      "debug",
		ImageUseIgnore.String():                                "ignore",
		DetectionFit.String():                                  "fit",
		ResidualEdges.String():                                 "edges",
		DistortionKannalaBrandt.String():                       "Kannala-Brandt",
		Method(99).String():                                    "99",
		Phase(0).String():                                      "0",
		FlagAxisAtLimit.String():                               "axis at limit",
		TerminationStep.String():                               "step",
		LimbSameLine.String():                                  "same line",
		EndFromBorder.String():                                 "border",
		EndFromPoints.String():                                 "points",
		ColourBGRA.String():                                    "BGRA",
		(InputPoints | InputImage).String():                    "points, image",
		FlagUncertaintyUnknown.String():                        "uncertainty unknown",
		FlagPoorFit.String():                                   "poor fit",
		(FlagEdgesIgnored | FlagNotConverged | 1<<30).String(): "edges ignored, not converged, 30",
		Flags(0).String():                                      "",
	} {
		if got != want {
			t.Errorf("%q is not %q", got, want)
		}
	}
}

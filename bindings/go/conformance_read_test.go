package cylfuse

import (
	"encoding/base64"
	"encoding/binary"
	"encoding/json"
	"math"
	"reflect"
)

// Reads the golden cases of bindings/conformance, whose README describes the format.

// number is a number of the file, where null is NaN.
type number float64

func (n *number) UnmarshalJSON(text []byte) error {
	if string(text) == "null" {
		*n = number(math.NaN())
		return nil
	}
	return json.Unmarshal(text, (*float64)(n))
}

type caseModel struct {
	Point, Direction [3]number
	Radius           number
}

type caseColumns struct {
	Array  string
	Column int
}

type casePoints struct {
	caseColumns
	Weights, Normals *caseColumns
}

type casePose struct {
	Rotation    [9]number
	Translation [3]number
}

type caseStep struct {
	Call           string
	Options        map[string]json.RawMessage
	Index          int
	Camera         *string
	Pose           *casePose
	Inputs         []string
	Model, A, B    *caseModel
	Points         json.RawMessage
	Segments       json.RawMessage
	Pixels         [][2]number
	Reach          float64
	Weights        []float64
	Mask           string
	Label          uint8
	Depth, Image   string
	Gamma          float64
	Scale          number
	MinDepth       number `json:"min_depth"`
	MaxDepth       number `json:"max_depth"`
	Kind           string
	Layout         string
	Scalar, Format string
}

type caseFile struct {
	Arrays map[string]struct {
		Type  string
		Shape []int
		Data  string
	}
	Cameras map[string]struct {
		DistortionModel string `json:"distortion_model"`
		Width, Height   int
		FX, FY, CX, CY  number
		Distortion      [8]number
	}
	Cases []struct {
		Name  string
		Steps []caseStep
	}
}

// The names of the enumerations, by their numbers.
var caseNames = map[string][]string{
	"method":           {"FUSED", "POINTS", "RANSAC", "EBERLY"},
	"objective":        {"ROBUST", "PAPER"},
	"start":            {"AUTO", "LIMBS", "MOMENTS", "RANSAC", "MODEL", "LAST"},
	"near_wall":        {"AUTO", "ON", "OFF"},
	"chart":            {"AUTO", "LOCAL", "ORTHONORMAL"},
	"edge_use":         {"REFINE", "AS_GIVEN"},
	"extent_rule":      {"AUTO", "EXTREMES", "LOCATED"},
	"distortion_model": {"NONE", "BROWN_CONRADY", "KANNALA_BRANDT"},
	"kind":             {"", "POINTS", "EDGES"},
	"layout":           {"PACKED", "ORGANISED"},
	"order":            {"", "", "", "", "RGB8", "BGR8", "RGBA8", "BGRA8"},
	"image_use":        {"AUTO", "IGNORE"},
	"input":            {"POINTS", "DEPTH", "EDGES", "IMAGE"},
}

func caseEnumeration(kind, name string) int64 {
	for value, known := range caseNames[kind] {
		if known == name {
			return int64(value)
		}
	}
	panic(kind + " has no " + name)
}

func vectorOf(v [3]number) [3]float64 {
	return [3]float64{float64(v[0]), float64(v[1]), float64(v[2])}
}

func (model *caseModel) cylinder() *Cylinder {
	if model == nil {
		return nil
	}
	return &Cylinder{vectorOf(model.Point), vectorOf(model.Direction), float64(model.Radius)}
}

// array decodes the elements of an array into the type of them.
func (file *caseFile) array(name string) (elements any, shape []int) {
	stored, ok := file.Arrays[name]
	if !ok {
		panic("no array " + name)
	}
	bytes, err := base64.StdEncoding.DecodeString(stored.Data)
	if err != nil {
		panic(err)
	}
	switch stored.Type {
	case "u8":
		return bytes, stored.Shape
	case "u16":
		values := make([]uint16, len(bytes)/2)
		for i := range values {
			values[i] = binary.LittleEndian.Uint16(bytes[2*i:])
		}
		return values, stored.Shape
	case "f32":
		values := make([]float32, len(bytes)/4)
		for i := range values {
			values[i] = math.Float32frombits(binary.LittleEndian.Uint32(bytes[4*i:]))
		}
		return values, stored.Shape
	case "f64":
		values := make([]float64, len(bytes)/8)
		for i := range values {
			values[i] = math.Float64frombits(binary.LittleEndian.Uint64(bytes[8*i:]))
		}
		return values, stored.Shape
	}
	panic("no type " + stored.Type)
}

func pointsOfCase[T float32 | float64](file *caseFile, given casePoints) PointCloud {
	columns := func(of *caseColumns) (data []T, width, height, stride int) {
		elements, shape := file.array(of.Array)
		if len(shape) == 2 {
			shape = []int{1, shape[0], shape[1]}
		}
		return elements.([]T)[of.Column:], shape[1], shape[0], shape[2]
	}
	var points Points[T]
	points.Data, points.Width, points.Height, points.PointStride = columns(&given.caseColumns)
	points.RowStride = points.Width * points.PointStride
	if given.Weights != nil {
		var width int
		points.Weights, width, _, points.WeightStride = columns(given.Weights)
		points.WeightRowStride = width * points.WeightStride
	}
	if given.Normals != nil {
		var width int
		points.Normals, width, _, points.NormalStride = columns(given.Normals)
		points.NormalRowStride = width * points.NormalStride
	}
	return points
}

func (file *caseFile) points(text json.RawMessage) PointCloud {
	var given casePoints
	if err := json.Unmarshal(text, &given); err != nil {
		panic(err)
	}
	if file.Arrays[given.Array].Type == "f32" {
		return pointsOfCase[float32](file, given)
	}
	return pointsOfCase[float64](file, given)
}

func (file *caseFile) mask(step *caseStep) *Mask {
	if step.Mask == "" {
		return nil
	}
	elements, shape := file.array(step.Mask)
	return &Mask{Data: elements.([]uint8), Width: shape[1], Height: shape[0], Label: step.Label}
}

func (file *caseFile) depth(step *caseStep) Depth {
	elements, shape := file.array(step.Depth)
	scale, min, max := float64(step.Scale), float64(step.MinDepth), float64(step.MaxDepth)
	if stored, ok := elements.([]uint16); ok {
		return DepthImage[uint16]{Data: stored, Width: shape[1], Height: shape[0], Scale: scale, MinDepth: min, MaxDepth: max}
	}
	return DepthImage[float32]{Data: elements.([]float32), Width: shape[1], Height: shape[0], Scale: scale, MinDepth: min, MaxDepth: max}
}

func (file *caseFile) image(step *caseStep) Image {
	elements, shape := file.array(step.Image)
	width, height := shape[1], shape[0]
	switch stored := elements.(type) {
	case []uint8:
		if len(shape) == 3 {
			order := map[int]ColourOrder{3: ColourRGB, 4: ColourRGBA}[shape[2]]
			if step.Format != "" {
				order = ColourOrder(caseEnumeration("order", step.Format))
			}
			return ColourImage{Data: stored, Order: order, Width: width, Height: height, Gamma: step.Gamma}
		}
		return GreyImage[uint8]{Data: stored, Width: width, Height: height, Gamma: step.Gamma}
	case []uint16:
		return GreyImage[uint16]{Data: stored, Width: width, Height: height, Gamma: step.Gamma}
	}
	return GreyImage[float32]{Data: elements.([]float32), Width: width, Height: height, Gamma: step.Gamma}
}

func (step *caseStep) pose() Pose {
	var pose Pose
	for i, value := range step.Pose.Rotation {
		pose.Rotation[i/3][i%3] = float64(value)
	}
	pose.Translation = vectorOf(step.Pose.Translation)
	return pose
}

func (file *caseFile) depthCamera(step *caseStep) *DepthCamera {
	if step.Camera == nil {
		return nil
	}
	return &DepthCamera{file.intrinsics(step), step.pose()}
}

func (file *caseFile) intrinsics(step *caseStep) Intrinsics {
	camera, ok := file.Cameras[*step.Camera]
	if !ok {
		panic("no camera " + *step.Camera)
	}
	intrinsics := Intrinsics{Width: camera.Width, Height: camera.Height, FX: float64(camera.FX), FY: float64(camera.FY),
		CX: float64(camera.CX), CY: float64(camera.CY),
		DistortionModel: DistortionModel(caseEnumeration("distortion_model", camera.DistortionModel))}
	for i, coefficient := range camera.Distortion {
		intrinsics.Distortion[i] = float64(coefficient)
	}
	return intrinsics
}

func (step *caseStep) options() Options {
	options := DefaultOptions()
	step.setOptions(&options)
	return options
}

func (step *caseStep) detectorOptions() DetectorOptions {
	options := DefaultDetectorOptions()
	step.setOptions(&options)
	return options
}

// setOptions sets the fields of a struct of options that the step names.
func (step *caseStep) setOptions(options any) {
	target := reflect.ValueOf(options).Elem()
	for i := 0; i < target.NumField(); i++ {
		name := snake(target.Type().Field(i).Name)
		text, ok := step.Options[name]
		if !ok {
			continue
		}
		delete(step.Options, name)
		var value number
		var text2 string
		field := target.Field(i)
		switch {
		case caseNames[name] != nil:
			if err := json.Unmarshal(text, &text2); err != nil {
				panic(err)
			}
			field.SetInt(caseEnumeration(name, text2))
			continue
		case name == "axis":
			var axis [3]number
			if err := json.Unmarshal(text, &axis); err != nil {
				panic(err)
			}
			field.Set(reflect.ValueOf(vectorOf(axis)))
			continue
		}
		if err := value.UnmarshalJSON(text); err != nil {
			panic(err)
		}
		if field.CanUint() {
			field.SetUint(uint64(value))
		} else {
			field.SetFloat(float64(value))
		}
	}
	for name := range step.Options {
		panic("no option " + name)
	}
}

func (step *caseStep) segments() (Segments[float64], error) {
	var rows [][4]number
	err := json.Unmarshal(step.Segments, &rows)
	segments := Segments[float64]{Weights: step.Weights}
	for _, row := range rows {
		for _, value := range row {
			segments.Data = append(segments.Data, float64(value))
		}
	}
	return segments, err
}

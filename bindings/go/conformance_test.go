package cylfuse

import (
	"bufio"
	"encoding/base64"
	"encoding/binary"
	"encoding/json"
	"errors"
	"fmt"
	"math"
	"os"
	"reflect"
	"regexp"
	"strings"
	"testing"
	"time"
)

// The golden cases of bindings/conformance, whose README describes the format.

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

type caseStep struct {
	Call           string
	Options        map[string]json.RawMessage
	Camera         string
	Model, A, B    *caseModel
	Points         json.RawMessage
	Segments       json.RawMessage
	Reach          float64
	Weights        []float64
	Mask           string
	Depth, Image   string
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
	"start":            {"AUTO", "LIMBS", "MOMENTS", "RANSAC", "MODEL"},
	"near_wall":        {"AUTO", "ON", "OFF"},
	"chart":            {"AUTO", "LOCAL", "ORTHONORMAL"},
	"edge_use":         {"REFINE", "AS_GIVEN"},
	"extent_rule":      {"AUTO", "EXTREMES", "LOCATED"},
	"distortion_model": {"NONE", "BROWN_CONRADY", "KANNALA_BRANDT"},
	"kind":             {"", "POINTS", "EDGES"},
	"layout":           {"PACKED", "ORGANISED"},
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

func (file *caseFile) mask(name string) *Mask {
	if name == "" {
		return nil
	}
	elements, shape := file.array(name)
	return &Mask{Data: elements.([]uint8), Width: shape[1], Height: shape[0]}
}

func (file *caseFile) depth(step *caseStep) Depth {
	elements, shape := file.array(step.Depth)
	scale, min, max := float64(step.Scale), float64(step.MinDepth), float64(step.MaxDepth)
	if stored, ok := elements.([]uint16); ok {
		return DepthImage[uint16]{Data: stored, Width: shape[1], Height: shape[0], Scale: scale, MinDepth: min, MaxDepth: max}
	}
	return DepthImage[float32]{Data: elements.([]float32), Width: shape[1], Height: shape[0], Scale: scale, MinDepth: min, MaxDepth: max}
}

func (file *caseFile) image(name string) Image {
	elements, shape := file.array(name)
	switch stored := elements.(type) {
	case []uint8:
		return GreyImage[uint8]{Data: stored, Width: shape[1], Height: shape[0]}
	case []uint16:
		return GreyImage[uint16]{Data: stored, Width: shape[1], Height: shape[0]}
	}
	return GreyImage[float32]{Data: elements.([]float32), Width: shape[1], Height: shape[0]}
}

func (file *caseFile) intrinsics(name string) Intrinsics {
	camera, ok := file.Cameras[name]
	if !ok {
		panic("no camera " + name)
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
	target := reflect.ValueOf(&options).Elem()
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
			options.Axis = vectorOf(axis)
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
	return options
}

var (
	afterSmall   = regexp.MustCompile(`([a-z])([A-Z])`)
	afterAcronym = regexp.MustCompile(`([A-Z])([A-Z][a-z])`)
)

// snake is the name of a field in C.
func snake(name string) string {
	return strings.ToLower(afterAcronym.ReplaceAllString(afterSmall.ReplaceAllString(name, "${1}_${2}"), "${1}_${2}"))
}

// outputs lists the numbers of a value by the names of the C interface.
type outputs map[string][]float64

func (out outputs) add(name string, value any) {
	v := reflect.ValueOf(value)
	switch {
	case v.Type() == reflect.TypeOf(time.Duration(0)):
	case v.CanFloat():
		out[name] = append(out[name], v.Float())
	case v.CanInt():
		out[name] = append(out[name], float64(v.Int()))
	case v.CanUint():
		out[name] = append(out[name], float64(v.Uint()))
	default:
		if out[name] == nil {
			out[name] = []float64{}
		}
		for i := 0; i < v.Len(); i++ {
			out.add(name, v.Index(i).Interface())
		}
	}
}

func (out outputs) addFields(prefix string, value any) {
	v := reflect.ValueOf(value)
	for i := 0; i < v.NumField(); i++ {
		name, field := snake(v.Type().Field(i).Name), v.Field(i).Interface()
		if cylinder, ok := field.(Cylinder); ok {
			out.addFields(strings.Replace(name, "cylinder", "model", 1)+".", cylinder)
		} else {
			out.add(prefix+name, field)
		}
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

func (file *caseFile) run(fitter *Fitter, step *caseStep) (out outputs, err error) {
	out = outputs{}
	// The outputs of a call, unless it failed.
	fields := func(value any, failure error) (outputs, error) {
		out.addFields("", value)
		return out, failure
	}
	model := step.Model.cylinder()
	switch step.Call {
	case "set_options":
		return out, fitter.SetOptions(step.options())
	case "get_options":
		return fields(fitter.Options())
	case "set_intrinsics":
		return out, fitter.SetIntrinsics(file.intrinsics(step.Camera))
	case "set_start_model":
		return out, fitter.SetStartModel(model)
	case "reserve":
		var points, segments int
		if err := json.Unmarshal(step.Points, &points); err != nil {
			return nil, err
		}
		if err := json.Unmarshal(step.Segments, &segments); err != nil {
			return nil, err
		}
		return out, fitter.Reserve(points, segments)
	case "clear":
		return out, fitter.Clear()
	case "cancel":
		return out, fitter.Cancel()
	case "push_points":
		return out, fitter.PushPoints(file.points(step.Points), file.mask(step.Mask))
	case "push_depth":
		return out, fitter.PushDepth(file.depth(step), file.mask(step.Mask))
	case "push_image":
		return out, fitter.PushImage(file.image(step.Image))
	case "push_edges":
		segments, err := step.segments()
		if err != nil {
			return nil, err
		}
		return out, fitter.PushEdges(segments)
	case "select_edges":
		segments, err := step.segments()
		if err != nil {
			return nil, err
		}
		limbs, err := fitter.SelectEdges(segments, model, step.Reach)
		out.add("selected", limbs)
		return out, err
	case "counts":
		return fields(fitter.Counts())
	case "fit":
		return fields(fitter.Fit())
	case "get_result":
		return fields(fitter.Result())
	case "evaluate":
		return fields(fitter.Evaluate(*model))
	case "residuals":
		residuals, err := fitter.Residuals(model, ResidualKind(caseEnumeration("kind", step.Kind)))
		out.add("residuals", residuals)
		return out, err
	case "limb_samples":
		samples, err := fitter.LimbSamples()
		for _, name := range []string{"pixel", "sigma", "weight", "limb"} {
			out[name] = []float64{}
		}
		for _, sample := range samples {
			out.addFields("", sample)
		}
		return out, err
	case "diagnose":
		return fields(fitter.Diagnose(model))
	case "complete":
		layout := Layout(caseEnumeration("layout", step.Layout))
		if step.Scalar == "F32" {
			points, completion, err := Complete[float32](fitter, model, file.mask(step.Mask), layout)
			out.add("points", points)
			return fields(completion, err)
		}
		points, completion, err := Complete[float64](fitter, model, file.mask(step.Mask), layout)
		out.add("points", points)
		return fields(completion, err)
	case "complete_depth":
		if step.Format == "U16" {
			image, completion, err := CompleteDepth[uint16](fitter, model, file.mask(step.Mask), float64(step.Scale))
			out.add("depth", image.Data)
			return fields(completion, err)
		}
		image, completion, err := CompleteDepth[float32](fitter, model, file.mask(step.Mask), float64(step.Scale))
		out.add("depth", image.Data)
		return fields(completion, err)
	case "extent":
		return fields(fitter.Extent(model, file.mask(step.Mask)))
	case "distances":
		distances, err := model.Distances(file.points(step.Points))
		out.add("distances", distances)
		return out, err
	case "project":
		lines, err := model.Project(file.intrinsics(step.Camera))
		out.add("lines", lines)
		return out, err
	case "compare":
		return fields(step.A.cylinder().Compare(*step.B.cylinder()))
	}
	return nil, fmt.Errorf("no call %s", step.Call)
}

// TestConformance runs the golden cases and writes the results for check.py, which compares them with the committed
// values and with the bits of C.
func TestConformance(t *testing.T) {
	path := os.Getenv("CYLFUSE_CONFORMANCE_OUTPUT")
	if path == "" {
		t.Skip("CYLFUSE_CONFORMANCE_OUTPUT, the path for the results, is not set: test.sh sets it and compares them")
	}
	text, err := os.ReadFile("../conformance/cases.json")
	must(t, err)
	var file caseFile
	must(t, json.Unmarshal(text, &file))
	results, err := os.Create(path)
	must(t, err)
	defer results.Close()
	writer := bufio.NewWriter(results)
	for _, golden := range file.Cases {
		fitter := newFitter(t)
		for index := range golden.Steps {
			step := &golden.Steps[index]
			out, err := file.run(fitter, step)
			var failure *Error
			if errors.As(err, &failure) {
				status, _, _ := strings.Cut(failure.Status.Error(), ":")
				fmt.Fprintf(writer, "%s\t%d\terror\t%s\t%s\n", golden.Name, index, status, failure.Message)
				continue
			}
			if err != nil {
				t.Errorf("%s, step %d (%s): %v", golden.Name, index, step.Call, err)
				continue
			}
			fmt.Fprintf(writer, "%s\t%d\tok\n", golden.Name, index)
			for name, values := range out {
				words := make([]string, len(values))
				for i, value := range values {
					words[i] = fmt.Sprintf("%016x", math.Float64bits(value))
					if math.IsNaN(value) {
						words[i] = "nan"
					}
				}
				fmt.Fprintf(writer, "%s\t%d\t%s\t%s\n", golden.Name, index, name, strings.Join(words, " "))
			}
		}
	}
	must(t, writer.Flush())
}

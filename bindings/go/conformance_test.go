package cylfuse

import (
	"bufio"
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

// Runs the golden cases of bindings/conformance.

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
	case v.Kind() == reflect.Bool:
		bit := 0.0
		if v.Bool() {
			bit = 1
		}
		out[name] = append(out[name], bit)
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

// addItems lists each field of the items of a slice.
func (out outputs) addItems(items any) {
	v := reflect.ValueOf(items)
	for i := 0; i < v.Type().Elem().NumField(); i++ {
		out[snake(v.Type().Elem().Field(i).Name)] = []float64{}
	}
	for i := 0; i < v.Len(); i++ {
		out.addFields("", v.Index(i).Interface())
	}
}

// ofEstimate are the fields of a result that C has in cylfuse_cylinder_estimate.
var ofEstimate = regexp.MustCompile("^(model|start_|radius_|direction_|position_|covariance)")

// keepPart keeps one of the two structs of C that a result is made of.
func (out outputs) keepPart(ofCylinder bool) {
	for name := range out {
		if ofEstimate.MatchString(name) != ofCylinder {
			delete(out, name)
		}
	}
}

// addDetections lists what a search has found.
func (out outputs) addDetections(found []Detection) {
	for _, name := range []string{"score", "pixels", "model.point", "model.direction", "model.radius"} {
		out[name] = []float64{}
	}
	for _, one := range found {
		out.add("score", one.Score)
		out.add("pixels", one.Pixels)
		out.addFields("model.", one.Result.Cylinder)
	}
}

// caseRun has what the steps of a case work on.
type caseRun struct {
	*caseFile
	fitter   *Fitter
	frame    *Frame
	detector *Detector
}

// renew puts a new fitter and a new frame, those that are wanted, in the place of the old ones.
func (run *caseRun) renew(fitter, frame bool) (err error) {
	if fitter {
		if run.fitter != nil {
			err = run.fitter.Close()
		}
		if err == nil {
			run.fitter, err = NewFitter()
		}
	}
	if frame && err == nil {
		if run.frame != nil {
			err = run.frame.Close()
		}
		if err == nil {
			run.frame, err = NewFrame()
		}
	}
	return err
}

// set runs the steps without outputs; `known` is false for others.
func (run *caseRun) set(step *caseStep) (known bool, err error) {
	fitter, frame := run.fitter, run.frame
	switch step.Call {
	case "new_fitter":
		return true, run.renew(true, false)
	case "new_frame":
		return true, run.renew(false, true)
	case "set_options":
		return true, fitter.SetOptions(step.options())
	case "select_view":
		return true, fitter.SelectView(step.Index)
	case "set_pose":
		return true, fitter.SetPose(step.pose())
	case "frame_set_pose":
		return true, frame.SetPose(step.pose())
	case "set_intrinsics":
		return true, fitter.SetIntrinsics(run.intrinsics(step))
	case "frame_set_intrinsics":
		return true, frame.SetIntrinsics(run.intrinsics(step))
	case "set_depth_camera":
		return true, fitter.SetDepthCamera(run.depthCamera(step))
	case "frame_set_depth_camera":
		return true, frame.SetDepthCamera(run.depthCamera(step))
	case "set_start_model":
		return true, fitter.SetStartModel(step.Model.cylinder())
	case "reserve":
		var points, segments int
		if err := json.Unmarshal(step.Points, &points); err != nil {
			return true, err
		}
		if err := json.Unmarshal(step.Segments, &segments); err != nil {
			return true, err
		}
		return true, fitter.Reserve(points, segments)
	case "clear":
		return true, fitter.Clear()
	case "clear_input":
		var inputs Input
		for _, name := range step.Inputs {
			inputs |= 1 << caseEnumeration("input", name)
		}
		return true, fitter.ClearInput(inputs)
	case "cancel":
		return true, fitter.Cancel()
	case "push_points":
		return true, fitter.PushPoints(run.points(step.Points), run.mask(step))
	case "push_depth":
		return true, fitter.PushDepth(run.depth(step), run.mask(step))
	case "frame_set_depth":
		return true, frame.SetDepth(run.depth(step))
	case "push_image":
		return true, fitter.PushImage(run.image(step))
	case "frame_set_image":
		return true, frame.SetImage(run.image(step))
	case "push_edges":
		segments, err := step.segments()
		if err != nil {
			return true, err
		}
		return true, fitter.PushEdges(segments)
	case "use_frame":
		return true, fitter.UseFrame(frame, run.mask(step))
	case "detector_set_options":
		return true, run.detector.SetOptions(step.detectorOptions())
	case "detector_set_fit_options":
		return true, run.detector.SetFitOptions(step.options())
	case "detector_cancel":
		return true, run.detector.Cancel()
	case "new_detector":
		err := run.detector.Close()
		if err == nil {
			run.detector, err = NewDetector()
		}
		return true, err
	case "detect":
		_, err := run.detector.Detect(frame)
		return true, err
	case "detect_points":
		_, err := run.detector.DetectPoints(run.points(step.Points))
		return true, err
	case "detector_make_fitter":
		made, err := run.detector.Fitter(step.Index)
		if err != nil {
			return true, err
		}
		run.fitter = made
		return true, fitter.Close()
	}
	return false, nil
}

// get runs the steps with outputs.
func (run *caseRun) get(step *caseStep) (out outputs, err error) {
	out = outputs{}
	// The outputs of a call, unless it failed.
	fields := func(value any, failure error) (outputs, error) {
		out.addFields("", value)
		return out, failure
	}
	items := func(value any, failure error) (outputs, error) {
		out.addItems(value)
		return out, failure
	}
	// list has only one, of this name.
	list := func(name string, value any, failure error) (outputs, error) {
		out.add(name, value)
		return out, failure
	}
	fitter, model := run.fitter, step.Model.cylinder()
	switch step.Call {
	case "get_options":
		return fields(fitter.Options())
	case "view_count":
		count, err := fitter.ViewCount()
		return list("count", count, err)
	case "select_edges":
		segments, err := step.segments()
		if err != nil {
			return nil, err
		}
		limbs, err := fitter.SelectEdges(segments, model, step.Reach)
		return list("selected", limbs, err)
	case "counts":
		return fields(fitter.Counts())
	case "fit":
		return fields(fitter.Fit())
	case "get_result", "get_cylinder":
		out, err := fields(fitter.Result())
		out.keepPart(step.Call == "get_cylinder")
		return out, err
	case "detector_get_options":
		return fields(run.detector.Options())
	case "detector_get_fit_options":
		return fields(run.detector.FitOptions())
	case "detector_count":
		found, err := run.detector.Detections()
		return list("count", len(found), err)
	case "detector_detections":
		found, err := run.detector.Detections()
		out.addDetections(found)
		return out, err
	case "detector_get_result", "detector_get_cylinder", "detector_get_extent":
		// The list knows no such error as the library.
		if _, err := run.detector.Indices(step.Index); err != nil {
			return nil, err
		}
		found, err := run.detector.Detections()
		if err != nil {
			return nil, err
		}
		if step.Call == "detector_get_extent" {
			if extent := found[step.Index].Extent; extent != nil {
				return fields(*extent, nil)
			}
			// The fitter says why there is none.
			made, err := run.detector.Fitter(step.Index)
			if err != nil {
				return nil, err
			}
			defer made.Close()
			return fields(made.Extent(nil, nil))
		}
		out.addFields("", found[step.Index].Result)
		out.keepPart(step.Call == "detector_get_cylinder")
		return out, nil
	case "detector_labels":
		labels, err := run.detector.Labels()
		return list("labels", labels.Data, err)
	case "detector_indices":
		indices, err := run.detector.Indices(step.Index)
		return list("indices", indices, err)
	case "evaluate":
		return fields(fitter.Evaluate(*model))
	case "residuals":
		residuals, err := fitter.Residuals(model, ResidualKind(caseEnumeration("kind", step.Kind)))
		return list("residuals", residuals, err)
	case "point_weights":
		weights, inliers, err := fitter.PointWeights()
		out.add("weights", weights)
		return list("inliers", inliers, err)
	case "point_parts":
		parts, err := fitter.PointParts(model)
		return list("parts", parts, err)
	case "limbs":
		return items(fitter.Limbs())
	case "limb_samples":
		return items(fitter.LimbSamples())
	case "end_samples":
		return items(fitter.EndSamples(model, run.mask(step)))
	case "diagnose":
		return fields(fitter.Diagnose(model))
	case "complete":
		layout := Layout(caseEnumeration("layout", step.Layout))
		if step.Scalar == "F32" {
			points, completion, err := Complete[float32](fitter, model, run.mask(step), layout)
			out.add("points", points)
			return fields(completion, err)
		}
		points, completion, err := Complete[float64](fitter, model, run.mask(step), layout)
		out.add("points", points)
		return fields(completion, err)
	case "complete_depth":
		if step.Format == "U16" {
			image, completion, err := CompleteDepth[uint16](fitter, model, run.mask(step), float64(step.Scale))
			out.add("depth", image.Data)
			return fields(completion, err)
		}
		image, completion, err := CompleteDepth[float32](fitter, model, run.mask(step), float64(step.Scale))
		out.add("depth", image.Data)
		return fields(completion, err)
	case "extent":
		return fields(fitter.Extent(model, run.mask(step)))
	case "distances":
		distances, err := model.Distances(run.points(step.Points))
		return list("distances", distances, err)
	case "project":
		lines, err := model.Project(run.intrinsics(step))
		return list("lines", lines, err)
	case "compare":
		return fields(step.A.cylinder().Compare(*step.B.cylinder()))
	case "intrinsics_project":
		pixels, err := run.intrinsics(step).Project(run.points(step.Points))
		return list("pixels", pixels, err)
	case "intrinsics_unproject":
		pixels := make([][2]float64, len(step.Pixels))
		for i, pixel := range step.Pixels {
			pixels[i] = [2]float64{float64(pixel[0]), float64(pixel[1])}
		}
		rays, err := run.intrinsics(step).Unproject(pixels)
		return list("rays", rays, err)
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
		run := caseRun{caseFile: &file, detector: newDetector(t)}
		must(t, run.renew(true, true))
		for index := range golden.Steps {
			step := &golden.Steps[index]
			var out outputs
			known, err := run.set(step)
			if !known {
				out, err = run.get(step)
			}
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
		must(t, run.fitter.Close())
		must(t, run.frame.Close())
	}
	must(t, writer.Flush())
}

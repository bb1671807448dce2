package cylfuse

// #include "bridge.h"
import "C"

import (
	"sync"
	"unsafe"
)

// Frame is what one camera delivered at one time: intrinsics, pose, depth image, image. Any number of fitters use one
// frame without a copy, such as one for each cylinder of a scene. Made by NewFrame.
//
// A fitter takes what the frame holds at that time: what is set later, and Close, change nothing in fitters. Methods that
// fill a frame run one at a time; any number of goroutines may use it at once.
type Frame struct {
	object
	// state guards what follows.
	state sync.Mutex
	size  size
}

// size is that of a camera in pixels, 0 before its intrinsics are set.
type size struct{ width, height int }

// NewFrame makes a frame at the identity, without a camera and data. Close frees what it holds; a forgotten one is freed
// by the garbage collector, which does not see how much memory that is.
func NewFrame() (*Frame, error) {
	if err := checkLibrary(); err != nil {
		return nil, err
	}
	var handle *C.cylfuse_frame
	create := func() C.cylfuse_status { return C.cylfuse_frame_create(C.CYLFUSE_ABI_VERSION, &handle) }
	if err := withoutHandle(create); err != nil {
		return nil, err
	}
	frame := new(Frame)
	frame.own(&native{
		handle:    unsafe.Pointer(handle),
		destroy:   func(h unsafe.Pointer) C.cylfuse_status { return C.cylfuse_frame_destroy((*C.cylfuse_frame)(h)) },
		lastError: func(h unsafe.Pointer) *C.char { return C.cylfuse_frame_last_error((*C.cylfuse_frame)(h)) },
	})
	return frame, nil
}

// Close frees the frame; fitters that use it go on with what they need of it. A second Close does nothing. StatusBusy
// when a call on the frame is running: nothing is freed then.
func (frame *Frame) Close() error { return frame.close() }

// SetIntrinsics sets the colour camera; it comes before depth and image.
func (frame *Frame) SetIntrinsics(intrinsics Intrinsics) error {
	c, err := intrinsics.toC()
	if err != nil {
		return err
	}
	return frame.call(func(handle *C.cylfuse_frame) C.cylfuse_status {
		status := C.cylfuse_frame_set_intrinsics(handle, &c)
		if status == C.CYLFUSE_STATUS_OK {
			frame.state.Lock()
			defer frame.state.Unlock()
			frame.size = size{intrinsics.Width, intrinsics.Height}
		}
		return status
	})
}

// SetPose sets where the camera is in the reference frame; the identity at first.
func (frame *Frame) SetPose(pose Pose) error {
	rotation, translation := pose.toC()
	return frame.call(func(handle *C.cylfuse_frame) C.cylfuse_status {
		return C.cylfuse_frame_set_pose(handle, &rotation[0], &translation[0])
	})
}

// SetDepthCamera gives the depth a camera of its own, for depth that is not registered to the colour image. nil
// takes it away.
func (frame *Frame) SetDepthCamera(camera *DepthCamera) error {
	c, err := camera.toC()
	if err != nil {
		return err
	}
	return frame.call(func(handle *C.cylfuse_frame) C.cylfuse_status {
		return C.cylfuse_frame_set_depth_camera(handle, c.intrinsics, &c.rotation[0], &c.translation[0])
	})
}

// SetDepth sets the depth image, in place of an earlier one; intrinsics come before.
func (frame *Frame) SetDepth(depth Depth) error {
	view, err := depth.depthView()
	if err != nil {
		return err
	}
	return frame.call(func(handle *C.cylfuse_frame) C.cylfuse_status {
		return C.bridge_frame_set_depth(handle, &view.view, view.data)
	})
}

// SetImage sets the image, grey or in colour, in place of an earlier one; intrinsics come before.
func (frame *Frame) SetImage(image Image) error {
	view, err := image.imageView()
	if err != nil {
		return err
	}
	return frame.call(func(handle *C.cylfuse_frame) C.cylfuse_status {
		return C.bridge_frame_set_image(handle, &view.view, view.data)
	})
}

func (frame *Frame) call(run func(handle *C.cylfuse_frame) C.cylfuse_status) error {
	return frame.object.call(func(handle unsafe.Pointer) C.cylfuse_status { return run((*C.cylfuse_frame)(handle)) })
}

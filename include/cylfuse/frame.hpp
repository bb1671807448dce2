/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file frame.hpp
 * What one camera delivered at one time, for any number of fitters. Include cylfuse.hpp, which says how it is meant.
 */

#ifndef CYLFUSE_FRAME_HPP
#define CYLFUSE_FRAME_HPP

#include <cylfuse/error.hpp>
#include <cylfuse/types.hpp>
#include <cylfuse/views.hpp>

#include <memory>

namespace cylfuse {
#ifdef CYLFUSE_NO_EXCEPTIONS
inline namespace without_exceptions {
#else
inline namespace with_exceptions {
#endif

/**
 * Cameras, pose, depth image and image of one view, which any number of fitters use without a copy by
 * Fitter::use_frame(): one for each cylinder of a scene. A fitter takes what the frame holds at that time: what is set
 * later, and its destruction, change nothing in fitters.
 *
 * Moves but does not copy. A frame that was moved from holds nothing: all its calls fail with Status::NullPointer.
 */
class Frame {
public:
#ifndef CYLFUSE_NO_EXCEPTIONS
    /** A frame at the identity, without a camera and data. */
    Frame() : Frame(create()) {}
#endif
    /** A frame at the identity, without a camera and data. */
    static Returned<Frame> create()
    {
        cylfuse_frame *made = nullptr;
        const cylfuse_status status = cylfuse_frame_create(CYLFUSE_ABI_VERSION, &made);
        return detail::finish_call(status, Frame(made));
    }
    /** Takes over a frame of the C interface; NULL for one that holds nothing. */
    explicit Frame(cylfuse_frame *frame) noexcept : handle_(frame) {}

    /** The frame for functions of the C interface; stays owned. */
    cylfuse_frame *handle() const noexcept { return handle_.get(); }
    /** The text of the failure of the last call, as Fitter::last_error(). */
    const char *last_error() const noexcept { return cylfuse_frame_last_error(handle()); }
    /** Gives the frame away: cylfuse_frame_destroy() is up to the caller then. */
    cylfuse_frame *release() noexcept { return handle_.release(); }

    /** Sets the colour camera; it comes before depth and image. */
    Returned<void> set_intrinsics(const cylfuse_intrinsics &intrinsics)
    {
        return finish(cylfuse_frame_set_intrinsics(handle(), &intrinsics));
    }
    /** Sets the pose: from the camera frame to the reference frame. */
    Returned<void> set_pose(const RigidMotion &pose)
    {
        return finish(cylfuse_frame_set_pose(handle(), pose.rotation.data(), pose.translation.data()));
    }
    /** Gives the depth a camera of its own; `to_colour` leads from its frame to the colour camera. */
    Returned<void> set_depth_camera(const cylfuse_intrinsics &intrinsics, const RigidMotion &to_colour)
    {
        return finish(cylfuse_frame_set_depth_camera(handle(), &intrinsics, to_colour.rotation.data(),
                                                     to_colour.translation.data()));
    }
    /** Takes the depth camera away. */
    Returned<void> clear_depth_camera()
    {
        return finish(cylfuse_frame_set_depth_camera(handle(), nullptr, nullptr, nullptr));
    }
    /** Sets the depth image. */
    Returned<void> set_depth(const DepthView &depth) { return finish(cylfuse_frame_set_depth(handle(), &depth)); }
    /** Sets the image, grey or in colour. */
    Returned<void> set_image(const ImageView &image) { return finish(cylfuse_frame_set_image(handle(), &image)); }

private:
    struct Destroy {
        void operator()(cylfuse_frame *frame) const noexcept { cylfuse_frame_destroy(frame); }
    };

    Returned<void> finish(cylfuse_status status) const
    {
        return detail::finish(Status(status),
                              status == CYLFUSE_STATUS_OK ? "" : cylfuse_frame_last_error(handle()));
    }

    std::unique_ptr<cylfuse_frame, Destroy> handle_;
};

} // inline namespace
} // namespace cylfuse

#endif

/* A scene of two cylinders before a wall, for the tests of detectors. */
#ifndef DETECTOR_H
#define DETECTOR_H

#include "check.h"

enum { WIDE = 160, HIGH = 120, ALL = WIDE * HIGH, CYLINDERS = 2 };

extern cylfuse_intrinsics pair_camera;
void make_pair(void);

/* Views of it. */
cylfuse_depth_view pair_depth(void);
cylfuse_points_view pair_points(void);
cylfuse_frame *pair_frame(int with_image);

cylfuse_detector *new_detector(void);
cylfuse_detector_options default_options(void);
/* How many cylinders the last scene has. */
size_t count_of(const cylfuse_detector *detector);

#endif

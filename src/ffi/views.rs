//! From pointers and strides to the checked views of the safe library.

use super::constants::cylfuse_distortion;
use super::lists::numbers;
use super::status::Failure;
use super::structs::{
    cylfuse_cylinder, cylfuse_depth_view, cylfuse_image_view, cylfuse_intrinsics, cylfuse_mask_view,
    cylfuse_points_view, cylfuse_segments_view,
};
use crate::camera::{Distortion, Intrinsics};
use crate::error::{Error, with_room};
use crate::geometry::{Cylinder, RigidMotion};
use crate::observations::{
    DepthRange, DepthView, EdgeSegment, ImageView, MaskView, Pixels, PointsView, Scalar, Strided, VectorsView,
};
use nalgebra::{Matrix3, Vector2, Vector3};

/// A grid of elements as the caller describes it, strides in bytes, 0 = packed.
pub(super) struct Grid {
    /// What it is, for messages: `points`, `depth`.
    pub name: &'static str,
    /// What one element is, for messages.
    pub element: &'static str,
    pub width: usize,
    pub height: usize,
    pub element_size: usize,
    pub element_stride: isize,
    pub row_stride: isize,
}

/// A grid whose elements lie at distinct places that an address can reach.
#[derive(Debug, Clone, Copy)]
pub(super) struct CheckedGrid {
    width: usize,
    height: usize,
    element_size: usize,
    element_stride: isize,
    row_stride: isize,
    /// Byte offsets of the lowest byte and of the end of the highest one from the first element.
    reach: (isize, isize),
}

impl Grid {
    /// Fills in packed strides and checks that the elements do not overlap and lie where `address` can reach.
    pub fn check<T>(&self, address: *const T) -> Result<CheckedGrid, Failure> {
        let &Grid { name, width, height, element_size, .. } = self;
        let too_large = || {
            let size =
                format!("{width} x {height} with strides {} and {}", self.element_stride, self.row_stride);
            Failure::argument(format!("{name}: the size"), size, "fit into memory")
        };
        if width == 0 || height == 0 {
            let (element_stride, row_stride) = (self.element_stride, self.row_stride);
            return Ok(CheckedGrid {
                width,
                height,
                element_size,
                element_stride,
                row_stride,
                reach: (0, 0),
            });
        }
        if address.is_null() {
            return Err(Failure::NullPointer { name });
        }
        let element_stride = match self.element_stride {
            0 => element_size as isize,
            stride => stride,
        };
        let row_stride = match self.row_stride {
            0 => isize::try_from(width)
                .ok()
                .and_then(|w| w.checked_mul(element_stride))
                .ok_or_else(too_large)?,
            stride => stride,
        };
        let reach = Strided::reach((width, height), element_size, (element_stride, row_stride))
            .ok_or_else(too_large)?;
        let fits = reach.1.checked_sub(reach.0).is_some()
            && address.addr().checked_add_signed(reach.0).is_some()
            && address.addr().checked_add_signed(reach.1).is_some();
        if !fits {
            return Err(too_large());
        }
        self.check_overlap(element_stride, row_stride)?;
        Ok(CheckedGrid { width, height, element_size, element_stride, row_stride, reach })
    }

    /// The memory of the grid, after a check.
    ///
    /// # Safety
    /// `first` is NULL or points to the first element, and all memory from the lowest to the highest byte of the
    /// elements is readable and not written to during `'a`.
    unsafe fn view<'a, T>(&self, first: *const T) -> Result<Strided<'a>, Failure> {
        let checked = self.check(first)?;
        // SAFETY: the caller promises the memory of the elements; the check has refused NULL unless there are none.
        unsafe { checked.view(first) }
    }

    /// Overlapping elements are a stride in elements instead of bytes. Rows may be the long way round, as in a
    /// transposed array.
    fn check_overlap(&self, element_stride: isize, row_stride: isize) -> Result<(), Failure> {
        let &Grid { name, element, width, height, element_size, .. } = self;
        let (across, down) = (element_stride.unsigned_abs(), row_stride.unsigned_abs());
        // Bytes that a line of elements takes.
        let line =
            |count: usize, stride: usize| (count - 1).saturating_mul(stride).saturating_add(element_size);
        let row_major =
            (width == 1 || across >= element_size) && (height == 1 || down >= line(width, across));
        let column_major =
            (height == 1 || down >= element_size) && (width == 1 || across >= line(height, down));
        if row_major || column_major {
            return Ok(());
        }
        if across < element_size {
            let what = format!("{name}: the stride of a {element}");
            let requirement = format!("be at least {element_size} bytes, or 0 for packed ones");
            return Err(Failure::argument(what, element_stride, requirement));
        }
        let requirement = format!("be at least {} bytes, or 0 for packed rows", line(width, across));
        Err(Failure::argument(format!("{name}: the stride of a row"), row_stride, requirement))
    }
}

impl CheckedGrid {
    /// The memory of the grid.
    ///
    /// # Safety
    /// Unless the grid is empty, `first` points to its first element, and all memory from its lowest to its
    /// highest byte is readable and not written to during `'a`. It is the address the grid was checked with.
    unsafe fn view<'a, T>(&self, first: *const T) -> Result<Strided<'a>, Failure> {
        let (lowest, end) = self.reach;
        let bytes: &[u8] = if lowest == end {
            &[]
        } else {
            // SAFETY: the caller promises the memory from the lowest to the highest byte; `check` found that its
            // length fits an isize.
            unsafe { std::slice::from_raw_parts(first.cast::<u8>().offset(lowest), (end - lowest) as usize) }
        };
        let strides = (self.element_stride, self.row_stride);
        let first = lowest.unsigned_abs();
        Ok(Strided::new(bytes, first, (self.width, self.height), self.element_size, strides)?)
    }

    /// The offset in bytes of an element from the first one.
    pub fn offset(&self, column: usize, row: usize) -> isize {
        debug_assert!(column < self.width && row < self.height);
        column as isize * self.element_stride + row as isize * self.row_stride
    }
}

fn pixel_grid(name: &'static str, (width, height): (u32, u32), size: usize, strides: (isize, isize)) -> Grid {
    let (element_stride, row_stride) = strides;
    let (width, height) = (width as usize, height as usize);
    Grid { name, element: "pixel", width, height, element_size: size, element_stride, row_stride }
}

/// A cloud.
///
/// # Safety
/// `data`, `weights` and `normals` are NULL or point to the memory that the fields describe, during `'a`.
pub(super) unsafe fn points_view<'a>(view: &cylfuse_points_view) -> Result<PointsView<'a>, Failure> {
    let scalar = view.scalar.read("points.scalar")?;
    if view.height == 0 && view.width > 0 {
        let requirement = "be at least 1: cylfuse_points_view_init sets that";
        return Err(Failure::argument("points.height", 0, requirement));
    }
    let grid = Grid {
        name: "points.data",
        element: "point",
        width: view.width,
        height: view.height,
        element_size: 3 * scalar.size(),
        element_stride: view.point_stride,
        row_stride: view.row_stride,
    };
    // SAFETY: the caller promises that `data` leads to what the grid describes.
    let points = unsafe { grid.view(view.data) }?;
    let weights = if view.weights.is_null() {
        None
    } else {
        let grid = Grid {
            name: "points.weights",
            element: "weight",
            element_size: scalar.size(),
            element_stride: view.weight_stride,
            row_stride: view.weight_row_stride,
            ..grid
        };
        // SAFETY: the caller promises that `weights` leads to what the grid describes.
        Some(unsafe { grid.view(view.weights) }?)
    };
    let normals = if view.normals.is_null() {
        None
    } else {
        let grid = Grid {
            name: "points.normals",
            element: "normal",
            element_stride: view.normal_stride,
            row_stride: view.normal_row_stride,
            ..grid
        };
        // SAFETY: the caller promises that `normals` leads to what the grid describes.
        Some(VectorsView::new(unsafe { grid.view(view.normals) }?, scalar))
    };
    Ok(PointsView { points: VectorsView::new(points, scalar), weights, normals })
}

/// Size of a depth pixel in bytes.
pub(super) fn pixel_size(format: Pixels) -> usize {
    match format {
        Pixels::U16 => 2,
        Pixels::F32 => 4,
    }
}

/// A depth image and the range of depths that count.
///
/// # Safety
/// `data` is NULL or points to the memory that the fields describe, during `'a`.
pub(super) unsafe fn depth_view<'a>(
    view: &cylfuse_depth_view,
) -> Result<(DepthView<'a>, DepthRange), Failure> {
    let format = view.format.read("depth.format")?;
    let strides = (view.pixel_stride, view.row_stride);
    let grid = pixel_grid("depth.data", (view.width, view.height), pixel_size(format), strides);
    // SAFETY: the caller promises that `data` leads to what the grid describes.
    let pixels = unsafe { grid.view(view.data) }?;
    let max = if view.max_depth == 0.0 { f64::INFINITY } else { view.max_depth };
    Ok((DepthView::new(pixels, format, view.scale)?, DepthRange { min: view.min_depth, max }))
}

/// A mask.
///
/// # Safety
/// `data` is NULL or points to the memory that the fields describe, during `'a`.
pub(super) unsafe fn mask_view<'a>(view: &cylfuse_mask_view) -> Result<MaskView<'a>, Failure> {
    let label = match u8::try_from(view.label) {
        Ok(0) => None,
        Ok(label) => Some(label),
        Err(_) => return Err(Failure::argument("mask.label", view.label, "lie in [0, 255]")),
    };
    if view.width == 0 || view.height == 0 {
        let (width, height) = (view.width as usize, view.height as usize);
        return Err(Error::EmptyMask { width, height }.into());
    }
    let grid = pixel_grid("mask.data", (view.width, view.height), 1, (view.pixel_stride, view.row_stride));
    // SAFETY: the caller promises that `data` leads to what the grid describes.
    let mask = MaskView::new(unsafe { grid.view(view.data) }?);
    Ok(match label {
        Some(label) => mask.of_label(label),
        None => mask,
    })
}

/// An image.
///
/// # Safety
/// `data` is NULL or points to the memory that the fields describe, during `'a`.
pub(super) unsafe fn image_view<'a>(view: &cylfuse_image_view) -> Result<ImageView<'a>, Failure> {
    let format = view.format.read("image.format")?;
    let size = format.pixel_bytes();
    let grid =
        pixel_grid("image.data", (view.width, view.height), size, (view.pixel_stride, view.row_stride));
    // SAFETY: the caller promises that `data` leads to what the grid describes.
    let linear = ImageView::new(unsafe { grid.view(view.data) }?, format);
    Ok(linear.with_gamma(view.gamma)?)
}

/// Edge segments.
///
/// # Safety
/// `data` and `weights` are NULL or point to the memory that the fields describe.
pub(super) unsafe fn segments(view: &cylfuse_segments_view) -> Result<Vec<EdgeSegment>, Failure> {
    let scalar = view.scalar.read("segments.scalar")?;
    let grid = Grid {
        name: "segments.data",
        element: "segment",
        width: view.count,
        height: 1,
        element_size: 4 * scalar.size(),
        element_stride: view.segment_stride,
        row_stride: 0,
    };
    // SAFETY: the caller promises that `data` leads to what the grid describes.
    let coordinates = unsafe { grid.view(view.data) }?;
    let weights = if view.weights.is_null() {
        None
    } else {
        let size = Scalar::F64.size();
        let grid = Grid {
            name: "segments.weights",
            element: "weight",
            element_size: size,
            element_stride: 0,
            ..grid
        };
        // SAFETY: the caller promises that `weights` leads to what the grid describes.
        Some(unsafe { grid.view(view.weights) }?)
    };
    let mut segments = with_room(view.count, "the edge segments")?;
    segments.extend((0..view.count).map(|index| {
        let at = |component| coordinates.scalar(scalar, index, 0, component);
        let endpoints = [Vector2::new(at(0), at(1)), Vector2::new(at(2), at(3))];
        EdgeSegment { endpoints, weight: weights.map_or(1.0, |w| w.scalar(Scalar::F64, index, 0, 0)) }
    }));
    Ok(segments)
}

/// A camera. Only checks what the safe library cannot see: unknown models and coefficients that the model does
/// not have.
pub(super) fn intrinsics(given: &cylfuse_intrinsics) -> Result<Intrinsics, Failure> {
    let &cylfuse_intrinsics { distortion_model: model, width, height, fx, fy, cx, cy, distortion, .. } =
        given;
    let (used, distortion) = match model {
        cylfuse_distortion::NONE => (0, Distortion::None),
        cylfuse_distortion::BROWN_CONRADY => (8, Distortion::BrownConrady(distortion)),
        cylfuse_distortion::KANNALA_BRANDT => {
            let [k1, k2, k3, k4, ..] = distortion;
            (4, Distortion::KannalaBrandt([k1, k2, k3, k4]))
        }
        _ => {
            let known = "be 0 (NONE), 1 (BROWN_CONRADY) or 2 (KANNALA_BRANDT)";
            return Err(Failure::argument("intrinsics.distortion_model", model.0, known));
        }
    };
    if let Some(index) = (used..8).find(|&index| given.distortion[index] != 0.0) {
        return Err(Failure::Library(Error::InvalidIntrinsics {
            name: format!("distortion[{index}]"),
            value: format!("{:?}", given.distortion[index]),
            requirement: format!(
                "be 0: the distortion model {} has {used} coefficients; set distortion_model, 1 (BROWN_CONRADY) for those \
                 of cv::calibrateCamera",
                model.0
            ),
        }));
    }
    Ok(Intrinsics { width, height, fx, fy, cx, cy, distortion })
}

impl From<&Intrinsics> for cylfuse_intrinsics {
    fn from(intrinsics: &Intrinsics) -> Self {
        let &Intrinsics { width, height, fx, fy, cx, cy, distortion: given } = intrinsics;
        let (distortion_model, coefficients) = match &given {
            Distortion::None => (cylfuse_distortion::NONE, &[][..]),
            Distortion::BrownConrady(all) => (cylfuse_distortion::BROWN_CONRADY, &all[..]),
            Distortion::KannalaBrandt(all) => (cylfuse_distortion::KANNALA_BRANDT, &all[..]),
        };
        let struct_size = size_of::<Self>() as u32;
        let mut distortion = [0.0; 8];
        distortion[..coefficients.len()].copy_from_slice(coefficients);
        Self { struct_size, distortion_model, width, height, fx, fy, cx, cy, distortion }
    }
}

/// A rotation, row by row, and a translation.
///
/// # Safety
/// `rotation` is NULL or points to 9 doubles, `translation` is NULL or points to 3.
pub(super) unsafe fn motion(rotation: *const f64, translation: *const f64) -> Result<RigidMotion, Failure> {
    // SAFETY: the caller promises NULL or 9 doubles.
    let rotation: [f64; 9] = unsafe { numbers(rotation, "rotation") }?;
    // SAFETY: the caller promises NULL or 3 doubles.
    let translation: [f64; 3] = unsafe { numbers(translation, "translation") }?;
    Ok(RigidMotion::new(Matrix3::from_row_slice(&rotation), translation.into())?)
}

/// A cylinder.
///
/// # Safety
/// `model` is NULL or points to a cylinder.
pub(super) unsafe fn cylinder(
    model: *const cylfuse_cylinder,
    name: &'static str,
) -> Result<Cylinder, Failure> {
    if model.is_null() {
        return Err(Failure::NullPointer { name });
    }
    // SAFETY: not NULL, so it is a cylinder, as the caller promises; no alignment is assumed.
    let cylfuse_cylinder { point, direction, radius } = unsafe { model.read_unaligned() };
    Ok(Cylinder::new(Vector3::from(point), Vector3::from(direction), radius)?)
}

/// A cylinder where NULL means none.
///
/// # Safety
/// As [`cylinder`].
pub(super) unsafe fn optional_cylinder(model: *const cylfuse_cylinder) -> Result<Option<Cylinder>, Failure> {
    if model.is_null() {
        return Ok(None);
    }
    // SAFETY: as the caller promises, it is a cylinder: it is not NULL.
    unsafe { cylinder(model, "model") }.map(Some)
}

impl From<&Cylinder> for cylfuse_cylinder {
    fn from(cylinder: &Cylinder) -> Self {
        Self {
            point: cylinder.axis.point.into(),
            direction: cylinder.axis.direction.into(),
            radius: cylinder.radius,
        }
    }
}

/// A plain output of the caller, checked before the work is done.
pub(super) struct Slot<T>(*mut T);

impl<T: Copy> Slot<T> {
    /// Checks the pointer.
    ///
    /// # Safety
    /// `pointer` is NULL or writable for a `T` as long as this value lives.
    pub unsafe fn new(pointer: *mut T, name: &'static str) -> Result<Self, Failure> {
        if pointer.is_null() { Err(Failure::NullPointer { name }) } else { Ok(Self(pointer)) }
    }

    pub fn write(&self, value: T) {
        // SAFETY: the obligation of `new`; no alignment is assumed.
        unsafe { self.0.write_unaligned(value) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(size: (usize, usize), strides: (isize, isize)) -> Grid {
        pixel_grid("depth.data", (size.0 as u32, size.1 as u32), 2, strides)
    }

    #[test]
    fn strides_in_elements_are_found_out() {
        let memory = [0_u16; 12];
        let check = |size, strides| grid(size, strides).check(memory.as_ptr());
        assert!(check((4, 3), (0, 0)).is_ok());
        assert!(
            check((4, 3), (2, 8)).is_ok() && check((4, 3), (2, -8)).is_ok() && check((4, 3), (-2, 8)).is_ok()
        );
        // Column by column, as in a transposed array.
        assert!(check((4, 3), (6, 2)).is_ok());
        let text = |strides| check((4, 3), strides).unwrap_err().to_string();
        assert_eq!(
            text((0, 4)),
            "depth.data: the stride of a row is 4; it must be at least 8 bytes, or 0 for packed rows"
        );
        assert_eq!(
            text((1, 8)),
            "depth.data: the stride of a pixel is 1; it must be at least 2 bytes, or 0 for packed ones"
        );
        // Strides along a single row or column do not matter.
        assert!(check((1, 3), (1, 2)).is_ok() && check((4, 1), (0, 1)).is_ok());
    }

    #[test]
    fn what_no_address_reaches_is_refused() {
        let memory = [0_u16; 12];
        for strides in [(isize::MAX, 0), (0, isize::MAX), (0, isize::MIN), (isize::MIN, isize::MIN)] {
            let text = grid((4, 3), strides).check(memory.as_ptr()).unwrap_err().to_string();
            assert!(text.contains("fit into memory"), "{text}");
        }
        // Below address zero.
        assert!(grid((2, 1), (isize::MIN + 2, 0)).check(memory.as_ptr()).is_err());
        let huge = Grid { width: usize::MAX, ..grid((4, 3), (0, 0)) };
        assert!(huge.check(memory.as_ptr()).is_err());
    }

    #[test]
    fn empty_grids_need_no_memory() {
        let checked = grid((0, 3), (1, isize::MAX)).check(std::ptr::null::<u8>()).unwrap();
        // SAFETY: the grid is empty.
        assert_eq!(unsafe { checked.view(std::ptr::null::<u8>()) }.unwrap().width(), 0);
        let failure = grid((1, 1), (0, 0)).check(std::ptr::null::<u8>()).unwrap_err();
        assert_eq!(failure.to_string(), "depth.data is NULL; give a pointer");
    }
}

//! Images of OpenCV in and out, and edges proposed by its line detector (feature `opencv`).
//!
//! The functions take a [`Mat`], or a part of one, and push or return what a [`Fitter`] knows. A part whose rows are not
//! adjacent is copied first. Errors name types as OpenCV does.
//!
//! ```no_run
//! use cylfuse::fitter::{Fitter, Method, Options};
//! use cylfuse::observations::DepthRange;
//! use opencv::core::Mat;
//!
//! fn radius(depth: &Mat, image: &Mat, matrix: &Mat, distortion: &Mat) -> cylfuse::error::Result<f64> {
//!     let mut fitter = Fitter::new();
//!     fitter.set_intrinsics(cylfuse::opencv::intrinsics(matrix, distortion, (640, 480))?)?;
//!     cylfuse::opencv::push_depth(&mut fitter, depth, 0.001, None, &DepthRange { min: 0.5, max: 0.9 })?;
//!     // From the points alone: it tells where to look for the limbs.
//!     fitter.set_options(Options { method: Method::Ransac, ..Options::default() })?;
//!     fitter.fit()?;
//!     let edges = cylfuse::opencv::propose_edges(&fitter, image, 0.0)?;
//!     fitter.set_options(Options::default())?;
//!     fitter.push_edges(&edges)?;
//!     Ok(fitter.fit()?.cylinder.radius)
//! }
//! ```

use crate::camera::{Distortion, Intrinsics};
use crate::error::{Error, Result};
use crate::fitter::Fitter;
use crate::geometry::Cylinder;
use crate::observations::{
    DepthRange, DepthView, EdgeSegment, ImageFormat, ImageView, MaskView, Pixels, PointsView, Scalar,
    Strided, VectorsView,
};
use crate::scene::Scene;
use nalgebra::Vector2;
use opencv::core::{
    CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_32FC1, CV_32FC3, CV_64FC1, CV_64FC3, Mat, MatTraitConst,
    MatTraitConstManual, ToInputArray, Vec4f, Vector,
};
use opencv::imgproc::{self, LineSegmentDetectorTrait};
use std::borrow::Cow;

/// A failure inside OpenCV, such as out of memory.
#[allow(clippy::needless_pass_by_value, reason = "for map_err")]
fn inside(error: opencv::Error) -> Error {
    Error::Unsupported { what: format!("OpenCV failed: {error}"), remedy: "give an ordinary matrix" }
}

/// The name of a type of matrices, such as `CV_16UC1`.
fn type_name(kind: i32) -> String {
    opencv::core::type_to_string(kind).unwrap_or_else(|_| kind.to_string())
}

/// The elements of a matrix, row by row.
struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
    /// Columns and rows.
    size: (usize, usize),
    /// Bytes of an element.
    element: usize,
    /// Its type in the numbers of OpenCV.
    kind: i32,
}

impl<'a> Elements<'a> {
    /// The elements of a matrix that has one of these types, copied when it is a part of another matrix.
    fn of(matrix: &'a impl MatTraitConst, name: &str, types: &[i32]) -> Result<Self> {
        if matrix.empty() {
            return Err(Error::argument(
                name,
                "empty",
                "hold an image: was the file read, the camera ready?",
            ));
        }
        if matrix.dims() != 2 {
            let value = format!("of {} dimensions", matrix.dims());
            return Err(Error::argument(name, value, "have two dimensions"));
        }
        let kind = matrix.typ();
        if !types.contains(&kind) {
            let names: Vec<String> = types.iter().map(|&kind| type_name(kind)).collect();
            let value = format!("of type {}", type_name(kind));
            return Err(Error::argument(name, value, format!("be of type {}", names.join(" or "))));
        }
        let size = (matrix.cols() as usize, matrix.rows() as usize);
        let element = matrix.elem_size().map_err(inside)?;
        let bytes = if matrix.is_continuous() {
            Cow::Borrowed(matrix.data_bytes().map_err(inside)?)
        } else {
            let copy = matrix.try_clone().map_err(inside)?;
            Cow::Owned(copy.data_bytes().map_err(inside)?.to_vec())
        };
        Ok(Self { bytes, size, element, kind })
    }

    fn grid(&self) -> Result<Strided<'_>> {
        let (element, width) = (self.element as isize, self.size.0 as isize);
        Strided::new(&self.bytes, 0, self.size, self.element, (element, element * width))
    }
}

/// Calls `push` with a mask `CV_8UC1`, or without one.
fn with_mask<T>(mask: Option<&Mat>, push: impl FnOnce(Option<&MaskView<'_>>) -> Result<T>) -> Result<T> {
    let Some(mask) = mask else { return push(None) };
    let mask = Elements::of(mask, "the mask", &[CV_8UC1])?;
    push(Some(&MaskView::new(mask.grid()?)))
}

/// Pushes a depth image `CV_16UC1` or `CV_32FC1`, z = value · `unit`, inside a mask `CV_8UC1`: see
/// [`Fitter::push_depth`].
///
/// # Errors
/// `InvalidArgument` for an empty matrix or one of another type, and those of [`Fitter::push_depth`].
pub fn push_depth(
    fitter: &mut Fitter,
    depth: &impl MatTraitConst,
    unit: f64,
    mask: Option<&Mat>,
    range: &DepthRange,
) -> Result<()> {
    let depth = Elements::of(depth, "the depth image", &[CV_16UC1, CV_32FC1])?;
    let format = if depth.kind == CV_16UC1 { Pixels::U16 } else { Pixels::F32 };
    let view = DepthView::new(depth.grid()?, format, unit)?;
    with_mask(mask, |mask| fitter.push_depth(&view, mask, range))
}

/// Pushes an organised cloud `CV_32FC3` or `CV_64FC3`, such as `reproject_image_to_3d` gives, inside a mask
/// `CV_8UC1`: see [`Fitter::push_points`].
///
/// # Errors
/// `InvalidArgument` for an empty matrix or one of another type, and those of [`Fitter::push_points`].
pub fn push_points(fitter: &mut Fitter, points: &impl MatTraitConst, mask: Option<&Mat>) -> Result<()> {
    let points = Elements::of(points, "the matrix of points", &[CV_32FC3, CV_64FC3])?;
    let scalar = if points.kind == CV_32FC3 { Scalar::F32 } else { Scalar::F64 };
    let points = VectorsView::new(points.grid()?, scalar);
    let view = PointsView { points, weights: None, normals: None };
    with_mask(mask, |mask| fitter.push_points(&view, mask))
}

/// Pushes an image to the selected view: grey, `CV_8UC1`, `CV_16UC1` or `CV_32FC1`, or in colour as OpenCV has it,
/// `CV_8UC3` (BGR) or `CV_8UC4` (BGRA). `gamma` is 1 for values linear in light and 2.2 for sRGB, in which cameras and
/// image files usually come. See [`Fitter::push_image`] and [`ImageView::with_gamma`].
///
/// # Errors
/// `InvalidArgument` for an empty matrix or one of another type, and those of [`Fitter::push_image`] and
/// [`ImageView::with_gamma`].
pub fn push_image(fitter: &mut Fitter, image: &impl MatTraitConst, gamma: f64) -> Result<()> {
    let image = Elements::of(image, "the image", &[CV_8UC1, CV_16UC1, CV_32FC1, CV_8UC3, CV_8UC4])?;
    let format = match image.kind {
        CV_8UC1 => ImageFormat::U8,
        CV_16UC1 => ImageFormat::U16,
        CV_32FC1 => ImageFormat::F32,
        CV_8UC3 => ImageFormat::Bgr8,
        _ => ImageFormat::Bgra8,
    };
    fitter.push_image(&ImageView::new(image.grid()?, format).with_gamma(gamma)?)
}

/// A copy of an image in grey.
fn grey(image: &(impl MatTraitConst + ToInputArray)) -> Result<Mat> {
    let code = match image.typ() {
        CV_8UC3 => imgproc::COLOR_BGR2GRAY,
        CV_8UC4 => imgproc::COLOR_BGRA2GRAY,
        _ => return image.try_clone().map_err(inside),
    };
    let mut grey = Mat::default();
    imgproc::cvt_color_def(image, &mut grey, code).map_err(inside)?;
    Ok(grey)
}

/// A camera as OpenCV's `calibrate_camera` gives it: camera matrix 3 × 3 and 0, 4, 5 or 8 coefficients, both
/// `CV_64FC1`; columns and rows of its images.
///
/// # Errors
/// `InvalidIntrinsics` for matrices of another shape or type, a skew, another number of coefficients.
pub fn intrinsics(camera_matrix: &Mat, distortion: &Mat, (width, height): (u32, u32)) -> Result<Intrinsics> {
    let bad = |name: &str, value: String, requirement: &str| Error::InvalidIntrinsics {
        name: name.into(),
        value,
        requirement: requirement.into(),
    };
    let shape = |m: &Mat| format!("{} x {} of type {}", m.rows(), m.cols(), type_name(m.typ()));
    if (camera_matrix.rows(), camera_matrix.cols(), camera_matrix.typ()) != (3, 3, CV_64FC1) {
        return Err(bad("the camera matrix", shape(camera_matrix), "be 3 x 3 of type CV_64FC1"));
    }
    let k = |row, column| camera_matrix.at_2d::<f64>(row, column).copied().map_err(inside);
    for (row, column, expected) in [(0, 1, 0.0), (1, 0, 0.0), (2, 0, 0.0), (2, 1, 0.0), (2, 2, 1.0)] {
        let value = k(row, column)?;
        if value != expected {
            let name = format!("element ({row}, {column}) of the camera matrix");
            return Err(bad(&name, value.to_string(), &format!("be {expected}: [fx 0 cx; 0 fy cy; 0 0 1]")));
        }
    }
    let coefficients = if distortion.empty() {
        Vec::new()
    } else if distortion.typ() == CV_64FC1 && (distortion.rows() == 1 || distortion.cols() == 1) {
        let row = distortion.try_clone().map_err(inside)?;
        row.data_typed::<f64>().map_err(inside)?.to_vec()
    } else {
        let needed = "be one row or one column of type CV_64FC1";
        return Err(bad("the matrix of distortion coefficients", shape(distortion), needed));
    };
    let distortion =
        if coefficients.is_empty() { Distortion::None } else { Distortion::brown_conrady(&coefficients)? };
    Ok(Intrinsics { width, height, fx: k(0, 0)?, fy: k(1, 1)?, cx: k(0, 2)?, cy: k(1, 2)?, distortion })
}

/// The depth image of the selected view, completed by a model, or by the last fit, over a mask `CV_8UC1`, or over that
/// of the last depth image: `CV_32FC1` in the unit of length, 0 = none. See [`Fitter::complete_depth`].
///
/// # Errors
/// `InvalidArgument` for a mask of another type, and those of [`Fitter::complete_depth`].
pub fn complete_depth(fitter: &Fitter, model: Option<&Cylinder>, mask: Option<&Mat>) -> Result<Mat> {
    let mut depths: Vec<f32> = Vec::new();
    let mut width = 0;
    with_mask(mask, |mask| {
        fitter.complete_depth(model, mask, &mut |column, _, depth| {
            width = width.max(column + 1);
            depths.push(depth.map_or(0.0, |z| z as f32));
        })
    })?;
    let rows = depths.chunks(width.max(1)).collect::<Vec<_>>();
    Mat::from_slice_2d(&rows).map_err(inside)
}

/// The labels of a scene, `CV_16UC1`: 0 for none, else the number of the cylinder from 1 on.
///
/// # Errors
/// `Unsupported` for a scene without any pixel.
pub fn labels(scene: &Scene) -> Result<Mat> {
    let rows = scene.labels.chunks(scene.size.0.max(1)).collect::<Vec<_>>();
    Mat::from_slice_2d(&rows).map_err(inside)
}

/// Proposes edges where nobody gives them: OpenCV's line detector over an image of 8 bits, grey or colour, and of what
/// it finds the pieces on the two limbs of the last fit. That is best one to the points alone, such as by
/// [`Method::Ransac`](crate::fitter::Method::Ransac): others look at the mask, which may be bad. `reach` as for
/// [`Fitter::select_edges`]. Empty when no limb is in sight.
///
/// # Errors
/// `InvalidArgument` for an image that is empty or of another type, and those of [`Fitter::select_edges`].
pub fn propose_edges(
    fitter: &Fitter,
    image: &(impl MatTraitConst + ToInputArray),
    reach: f64,
) -> Result<Vec<EdgeSegment>> {
    /// At its usual scale of 0.8 the detector gives coordinates that are 1/8 pixel too small.
    const SCALE: f64 = 1.0;
    Elements::of(image, "the image", &[CV_8UC1, CV_8UC3, CV_8UC4])?;
    let grey = grey(image)?;
    // The other numbers are the defaults of OpenCV.
    let detector =
        imgproc::create_line_segment_detector(imgproc::LSD_REFINE_STD, SCALE, 0.6, 2.0, 22.5, 0.0, 0.7, 1024);
    let mut found = Vector::<Vec4f>::new();
    detector.map_err(inside)?.detect_def(&grey, &mut found).map_err(inside)?;
    let segments: Vec<EdgeSegment> = found
        .iter()
        .map(|line| {
            let [x1, y1, x2, y2] = line.0.map(f64::from);
            EdgeSegment { endpoints: [Vector2::new(x1, y1), Vector2::new(x2, y2)], weight: 1.0 }
        })
        .collect();
    let on_limbs = fitter.select_edges(&segments, None, reach)?;
    Ok(on_limbs.into_iter().flatten().map(|index| segments[index]).collect())
}

#[cfg(test)]
mod tests;

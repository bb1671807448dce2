//! What a frame file says that may be meant, but more often is a mistake that no other check notices.

use crate::cloud::Cloud;
use crate::frame::View;
use cylfuse::camera::{Distortion, Intrinsics};

/// Distances in metres that depth cameras measure. At 0.1 to 10 m a scale that takes millimetres for metres, or metres for
/// millimetres, leads out of them.
const DISTANCES: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// How far the principal point of a camera is from the middle, at most, in lengths of the side: lenses are centred to a few
/// hundredths.
const CENTRED: f64 = 0.1;

/// The same for a piece cut out of an image, which may be meant; beyond, the size of the image is rather that of another
/// resolution. That of half of it is off by a quarter, give or take what lenses are.
const CROPPED: f64 = 0.2;

/// The widest image of a lens that is no fisheye, in focal lengths: 140°. Focal lengths in millimetres make it wider by far.
const WIDEST: f64 = 5.5;

/// How far fx and fy differ at most: pixels are square to a few percent.
const SQUARE: f64 = 1.2;

/// The step of 32-bit floats, as a part of the size of a cloud, from which on small bodies lose their shape: of one 10 m wide these are
/// steps of a millimetre.
const LOST: f32 = 1e-4;

/// The least number of different depths in an image of a scene that is not rounded to nothing.
const LEAST_VALUES: usize = 8;

/// What may be wrong with the views of a frame, in words, where no radius may be below `radius_min`.
pub fn of_frame(views: &[View], radius_min: f64) -> Vec<String> {
    let mut all = Vec::new();
    for (index, view) in views.iter().enumerate() {
        let prefix = if views.len() > 1 { format!("views[{index}].") } else { String::new() };
        let own = view.depth_camera.as_ref();
        let cameras = [
            Some(("camera", view.camera.intrinsics())),
            own.map(|own| ("depth_camera", own.camera.intrinsics())),
        ];
        let found = cameras.into_iter().flatten().flat_map(|(name, intrinsics)| {
            [principal_point(name, intrinsics), focal_lengths(name, intrinsics)]
        });
        let found = found.chain([depth(view, radius_min)]);
        all.extend(found.flatten().map(|remark| format!("{prefix}{remark}")));
    }
    all
}

/// What may be wrong with a cloud that is searched. A fit of too few points fails.
pub fn of_cloud(cloud: &Cloud) -> Option<String> {
    let coordinates = |of: usize| match cloud {
        Cloud::F32(points) => range(points.iter().map(|point| point[of])),
        Cloud::F64(points) => range(points.iter().map(|point| point[of] as f32)),
    };
    let ranges = [coordinates(0), coordinates(1), coordinates(2)];
    let [Some(x), Some(y), Some(z)] = ranges else {
        return Some("the cloud has no points; check how it was written".into());
    };
    let largest = [x, y, z].as_flattened().iter().fold(0.0, |largest: f32, x| largest.max(x.abs()));
    let size = [x, y, z].iter().fold(0.0, |size: f32, [low, high]| size.max(high - low));
    let step = largest.next_up() - largest;
    // Of a single place nothing is lost.
    let is_lost = matches!(cloud, Cloud::F32(_)) && size > 0.0 && step > LOST * size;
    is_lost.then(|| {
        format!(
            "the coordinates reach {largest}, where 32-bit floats are {step} apart; store them as doubles, or subtract an offset first"
        )
    })
}

/// The least and the largest of all numbers that are finite.
fn range(numbers: impl Iterator<Item = f32>) -> Option<[f32; 2]> {
    let finite = numbers.filter(|number| number.is_finite());
    finite.map(|number| [number; 2]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

fn focal_lengths(camera: &str, intrinsics: &Intrinsics) -> Option<String> {
    let Intrinsics { width, height, fx, fy, distortion, .. } = *intrinsics;
    let fisheye = matches!(distortion, Distortion::KannalaBrandt(_));
    if !fisheye && (f64::from(width) / fx).max(f64::from(height) / fy) > WIDEST {
        let degrees = 2.0 * (f64::from(width) / fx / 2.0).atan().to_degrees();
        return Some(format!(
            "{camera}: fx = {fx} and fy = {fy} make an image {degrees:.0}° wide; give them in pixels, not in millimetres"
        ));
    }
    (fx.max(fy) / fx.min(fy) > SQUARE).then(|| {
        format!("{camera}: fx is {fx} and fy is {fy}, which are nearly the same in most cameras; check them, and their order")
    })
}

fn principal_point(camera: &str, intrinsics: &Intrinsics) -> Option<String> {
    let Intrinsics { width, height, cx, cy, .. } = *intrinsics;
    let off = |coordinate: f64, side: u32| ((coordinate + 0.5) / f64::from(side) - 0.5).abs();
    let given = off(cx, width).max(off(cy, height));
    let swapped = off(cy, width).max(off(cx, height));
    let question = if swapped <= CENTRED && given > CENTRED {
        "are cx and cy swapped?"
    } else if given > CROPPED {
        "are cx and cy those of another resolution?"
    } else {
        return None;
    };
    Some(format!(
        "{camera}: the principal point is ({cx}, {cy}), far from the middle of {width} x {height} pixels; {question}"
    ))
}

fn depth(view: &View, radius_min: f64) -> Option<String> {
    let mut counts = vec![0_usize; 1 << 16];
    view.depth.iter().for_each(|&value| counts[usize::from(value)] += 1);
    // 0 is what was not measured.
    counts[0] = 0;
    let values = counts.iter().filter(|&&count| count > 0).count();
    let (measured, mut nearer) = (counts.iter().sum::<usize>(), 0);
    let Some(median) = counts.iter().position(|count| {
        nearer += count;
        2 * nearer > measured
    }) else {
        return Some("depth: all pixels are 0, which stands for not measured".into());
    };
    let scale = view.depth_scale;
    let metres = median as f64 * scale;
    if values < LEAST_VALUES {
        return Some(format!(
            "depth: the image has only {values} different values; was depth in metres rounded to whole numbers? Write \
             millimetres, and a depth_scale of 0.001"
        ));
    }
    if radius_min > metres && DISTANCES.contains(&metres) {
        return Some(format!(
            "the least radius asked for is {radius_min} m, more than the middle distance of the scene, {metres:.4} m; give radii in metres"
        ));
    }
    (!DISTANCES.contains(&metres)).then(|| {
        format!(
            "depth_scale is {scale}, by which the middle distance of the scene is {metres:.4} m; give the metres for one \
             unit of the depth image: 0.001 where it is in millimetres"
        )
    })
}

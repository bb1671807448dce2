//! The small cloud on which the program of another library is tried before a long run.

use cylfuse::geometry::Cylinder;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// The cylinder of the trial, in metres: its middle, its direction, its radius.
const MIDDLE: [f64; 3] = [0.02, -0.01, 0.7];
const DIRECTION: [f64; 3] = [0.36, 0.8, 0.48];
const RADIUS: f64 = 0.04;

/// Points around and along it.
const AROUND: u32 = 60;
const ALONG: u32 = 50;

/// The largest error in the trial: of the radius and of the axis at the middle as parts of the radius, of the direction in
/// radians. It tells the right program from another one, not a good
/// library from a bad one: there is no noise.
const MOST: f64 = 0.1;

/// Half a cylinder of 100 mm, without noise.
pub fn points() -> impl Iterator<Item = Vector3<f64>> {
    let (middle, axis) = (Vector3::from(MIDDLE), Vector3::from(DIRECTION));
    let u = axis.cross(&Vector3::z()).normalize();
    let v = axis.cross(&u);
    let v = if v.z > 0.0 { -v } else { v };
    let steps = (0..AROUND).flat_map(|k| (0..ALONG).map(move |n| (f64::from(k), f64::from(n))));
    steps.map(move |(k, n)| {
        let (sine, cosine) = (PI * k / f64::from(AROUND - 1)).sin_cos();
        let along = 0.1 * (n / f64::from(ALONG - 1) - 0.5);
        middle + axis * along + (u * cosine + v * sine) * RADIUS
    })
}

/// Whether what was found is that cylinder.
///
/// # Errors
/// What is wrong, in words.
pub fn judge(found: &[Cylinder]) -> Result<(), String> {
    let [cylinder] = found else {
        return Err(format!("{} cylinders in the trial cloud, which is one cylinder", found.len()));
    };
    if !((cylinder.radius / RADIUS - 1.0).abs() <= MOST) {
        return Err(format!(
            "a radius of {:.4} m in the trial cloud, which is a cylinder with a radius of {RADIUS} m",
            cylinder.radius
        ));
    }
    let (middle, direction) = (Vector3::from(MIDDLE), Vector3::from(DIRECTION));
    let beside = (middle - cylinder.axis.nearest_to(&middle)).norm();
    let aslant = direction.cross(&cylinder.axis.direction).norm();
    match beside <= MOST * RADIUS && aslant <= MOST {
        true => Ok(()),
        false => Err(format!(
            "the radius of the trial cloud, but its axis {:.1} mm beside and {:.1} degrees off: a line is a point and a direction",
            1e3 * beside,
            aslant.clamp(0.0, 1.0).asin().to_degrees()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cloud_is_a_cylinder_that_only_its_own_radius_fits() {
        let own = Cylinder::new(MIDDLE.into(), DIRECTION.into(), RADIUS).unwrap();
        assert!(points().all(|point| {
            let beside = (point - own.axis.nearest_to(&point)).norm();
            (beside - RADIUS).abs() < 1e-12
        }));
        assert!(judge(&[own]).is_ok());
        let thick = Cylinder::new(MIDDLE.into(), DIRECTION.into(), 2.0 * RADIUS).unwrap();
        assert!(judge(&[thick]).unwrap_err().contains("0.0800 m"));
        let swapped = Cylinder::new(DIRECTION.into(), MIDDLE.into(), RADIUS).unwrap();
        assert!(judge(&[swapped]).unwrap_err().contains("degrees off"));
        assert!(judge(&[own, own]).unwrap_err().starts_with("2 cylinders"));
        assert!(judge(&[]).unwrap_err().starts_with("0 cylinders"));
    }
}

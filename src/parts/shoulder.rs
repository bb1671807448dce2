//! Shoulders, as those of bottles: the depth leaves the surface of the body little by little, and there is no rim.

use super::{BodyEnd, EndSign, REACH, SURPLUS, Sight};
use crate::statistics::median_and_deviation;

constants! {
    /// The part of the reach by which the depth of a shoulder has left that of the body where it is told.
    PART = 0.1, "reach";

    /// It begins before that, by a part of the length from there on to the reach: by none for a cone, by a half for an arc.
    BEFORE = 0.25, "";

    /// Its standard deviation, as a part of that length.
    DEVIATION = 0.3, "";

    /// That length at least. Nor is it less than what matching windows draw out.
    LEAST = 0.18, "radius";
}

/// The slices of a surface before its end, in which the depth is looked at, and how many of them are as long as the radius.
const SLICES: usize = 24;
const SLICES_OF_RADIUS: f64 = 16.0;

/// The end where a shoulder begins, in place of one by depth or far rim before which the depth leaves the surface little by little; `None`
/// where it does so at once, and of a cap. `pixel` is the length of one along the axis.
pub(super) fn shoulder(
    end: &BodyEnd,
    sights: &[Sight],
    radius: f64,
    reach: f64,
    pixel: f64,
    outward: f64,
) -> Option<BodyEnd> {
    if end.sign == EndSign::Cap {
        return None;
    }
    let slice = radius / SLICES_OF_RADIUS;
    let mut sums = [[0.0; 2]; SLICES];
    for sight in sights.iter().filter(|sight| !sight.nearer) {
        let before = outward * (end.position - sight.position) / slice;
        if (0.0..SLICES as f64).contains(&before) {
            let [sum, count] = &mut sums[before as usize];
            *sum += sight.distance.clamp(-reach, reach);
            *count += 1.0;
        }
    }
    if sums.iter().any(|[_, count]| *count == 0.0) {
        return None;
    }
    let means = sums.map(|[sum, count]| sum / count);
    // The half that is farther from the end tells where the surface of the body is, and how well.
    let mut own = [0.0; SLICES / 2];
    own.copy_from_slice(&means[SLICES / 2..]);
    let [level, scatter] = median_and_deviation(&mut own);
    let tolerance = (REACH.get() * scatter).max(PART.get() * reach);
    let slices = means.iter().position(|mean| mean - level >= -tolerance)?;
    let length = slices as f64 * slice;
    let position = end.position - outward * (1.0 + BEFORE.get()) * length;
    let deviation = end.deviation.hypot(DEVIATION.get() * length);
    let least = (LEAST.get() * radius).max(SURPLUS.get() * pixel);
    (length >= least).then_some(BodyEnd { position, deviation, sign: EndSign::Shoulder, recess: 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// What is seen of a surface of radius 1 whose depth is off by a function of the position, up to the reach of 0.05.
    fn end_of(off: impl Fn(f64) -> f64) -> Option<BodyEnd> {
        let sight = |k: u32| {
            let position = f64::from(k) / 500.0;
            let noise = 0.003 * f64::from(k * 7 % 5) - 0.006;
            Sight {
                position,
                point: Vector3::zeros(),
                distance: noise - off(position),
                nearer: false,
                facing: true,
            }
        };
        let sights: Vec<Sight> = (0..1500).map(sight).collect();
        let leaves = sights.iter().find(|sight| sight.distance < -0.05).unwrap();
        let end = BodyEnd { position: leaves.position, deviation: 0.01, sign: EndSign::Depth, recess: 0.0 };
        shoulder(&end, &sights, 1.0, 0.05, 0.01, 1.0)
    }

    #[test]
    fn shoulders_begin_where_the_depth_begins_to_leave() {
        for bend in [0.2, 0.5, 1.0] {
            // An arc from 1.9 on.
            let end = end_of(|position| 0.5 * bend * (position - 1.9).max(0.0).powi(2)).unwrap();
            assert_eq!(end.sign, EndSign::Shoulder);
            assert!(
                (end.position - 1.9).abs() < 2.0 * end.deviation && end.deviation < 0.25,
                "{bend}: {end:?}"
            );
        }
        let cone = end_of(|position| 0.1 * (position - 1.9).max(0.0)).unwrap();
        assert!((cone.position - 1.9).abs() < 2.0 * cone.deviation, "{cone:?}");
    }

    #[test]
    fn sharp_ends_and_caps_are_none() {
        assert_eq!(end_of(|position| if position > 1.9 { 1.0 } else { 0.0 }), None);
        // Windows draw the end out.
        assert_eq!(end_of(|position| 0.5 * (position - 1.9).max(0.0)), None);
    }
}

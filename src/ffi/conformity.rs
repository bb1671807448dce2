//! Whether a measured length conforms to its tolerance.

use super::handle::stateless;
use super::outcomes::{cylfuse_conformity, cylfuse_result_flags};
use super::status::{Failure, cylfuse_status};
use super::views::Slot;
use crate::fitter::{Flags, Tolerance};

/// Decides whether a measured length, such as a radius or a diameter, conforms to a tolerance, by the rule of ISO
/// 14253-1: the value with `coverage` deviations on either side lies within the limits, or outside, or the measurement
/// does not tell.
///
/// For the radius of a fit give `model.radius` and `radius_deviation` of its `cylfuse_cylinder_estimate`, for its
/// diameter twice of both, and `flags` of its `cylfuse_result`. Nothing is decided with a warning of which the deviation
/// says nothing: POOR_FIT, POINTS_AND_LIMBS_DISAGREE, BODY_TAPERS, MASK_DISAGREES, DEPTH_SHIFTED, HIDDEN_WALL,
/// MASK_ENDS_WITH_DEPTH, NOT_CONVERGED, RADIUS_AT_LIMIT, AXIS_AT_LIMIT, SCALE_HELD, RESOLUTION_LOST, UNCERTAINTY_UNKNOWN.
/// A deviation covers the noise of the data and what the options say that all points share, not a wrong scale of the depth
/// nor wrong intrinsics: a decision is as good as that. The length of an extent with an end that is not SEEN is that of the
/// visible part: of the whole only NOT_CONFORMING above the upper limit is true.
///
/// @param value in any unit of length, finite
/// @param deviation its standard deviation, in that unit. NaN, as of a method that states none, and 0, as of a radius
///   that the limits of the fit fix, decide nothing.
/// @param flags the warnings of the result; 0 for none
/// @param lower the lower limit, which conforms itself, in that unit; -INFINITY for none
/// @param upper the upper limit likewise, greater than `lower`; INFINITY for none. One of the two must be finite.
/// @param coverage the coverage factor k, finite and 0 or greater; 0 = 2
/// @param out_conformity where the decision goes
/// @return INVALID_ARGUMENT, also for an unknown bit of `flags`; nothing is written then
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cylfuse_decide_conformity(
    value: f64,
    deviation: f64,
    flags: cylfuse_result_flags,
    lower: f64,
    upper: f64,
    coverage: f64,
    out_conformity: *mut cylfuse_conformity,
) -> cylfuse_status {
    stateless(|| {
        // SAFETY: as the header asks, `out_conformity` is NULL or writable.
        let out = unsafe { Slot::new(out_conformity, "out_conformity") }?;
        let flags = Flags::from_bits(flags.0).ok_or_else(|| {
            Failure::argument("flags", flags.0, "be the flags of a result, of this library or an older one")
        })?;
        let mut tolerance = Tolerance::new(lower, upper)?;
        if coverage != 0.0 {
            tolerance = tolerance.with_coverage(coverage)?;
        }
        out.write(tolerance.decide(value, Some(deviation), flags)?.into());
        Ok(())
    })
}

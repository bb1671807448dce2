//! The votes of points for the scale of a cylinder, side by side.

use crate::geometry::LimbFrame;
use crate::memory::List;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// Points axis by axis.
#[derive(Default)]
pub(super) struct Points([List<f64>; 3]);

impl Points {
    pub fn push(&mut self, point: &Vector3<f64>) {
        self.0.iter_mut().zip(point.iter()).for_each(|(axis, x)| axis.push(*x));
    }

    pub fn len(&self) -> usize {
        self.0[0].len()
    }

    /// Every so many of them.
    pub fn every(&self, step: usize) -> Self {
        Self(self.0.each_ref().map(|axis| axis.iter().copied().step_by(step).collect()))
    }

    /// For each point the scale s that puts it on the near wall of a cylinder with its axis at distance s and the radius
    /// s sin γ, infinite when the ray to the point misses; they take the place of what is in the list.
    ///
    /// With p = (x, y) across the axis, x along ĉ: |p − s ĉ|² = s² sin²γ, and the near wall is the larger root.
    pub fn vote(&self, frame: &LimbFrame, votes: &mut List<f64>) {
        votes.resize(self.len(), 0.0);
        Arch::new().dispatch(Votes { points: self, frame, votes });
    }
}

/// What [`Points::vote`] does: a plain loop, which the compiler makes the widest instructions of the machine of; they all round
/// alike.
struct Votes<'a> {
    points: &'a Points,
    frame: &'a LimbFrame,
    votes: &'a mut [f64],
}

impl WithSimd for Votes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { points: Points([x, y, z]), frame, votes } = self;
        let &LimbFrame { toward, sideways, sin_gamma, cos_gamma, .. } = frame;
        for (vote, ((x, y), z)) in votes.iter_mut().zip(x.iter().zip(y.iter()).zip(z.iter())) {
            let along = x * toward.x + y * toward.y + z * toward.z;
            let across = x * sideways.x + y * sideways.y + z * sideways.z;
            let (ahead, aside) = (along * sin_gamma, across * cos_gamma);
            let discriminant = (ahead - aside) * (ahead + aside);
            let scale = (along + discriminant.sqrt()) / (cos_gamma * cos_gamma);
            *vote = if (along > 0.0) & (discriminant >= 0.0) { scale } else { f64::INFINITY };
        }
    }
}

//! Limbs that two cylinders of a scene claim.
//!
//! Where bodies lie side by side, the limb of one and that of the other may be taken for the same edge of the image, across the
//! gap between them or where one of them hides the limb of the other. It is the limb of one of them at most. Both are fitted again
//! without it, and it is left to the one whose other data expect their limb there.

use super::fits::Task;
use super::{Found, Outcome};
use crate::geometry::{Cylinder, LimbFrame};
use crate::limb_location::LimbObservation;
use nalgebra::{Matrix2, Vector2, Vector3};

constants! {
    /// The part of the shorter of two limbs along which they must be one edge.
    OVERLAP = 0.5, "length";

    /// Odds of this many to one tell whose limb an edge is. With less it is left to neither: a limb too few costs certainty, a wrong
    /// one the radius.
    ODDS = 3.0, "odds";

    /// What is less likely a cylinder claims nothing.
    CLAIMING = 0.5, "";
}

/// A piece of a line in the image, from end to end in ideal pixels.
pub(super) type Piece = [Vector2<f64>; 2];

/// An edge of the image at which two cylinders have a limb.
struct Contest {
    /// Both cylinders, by their numbers.
    cylinders: [usize; 2],
    /// The piece along which both have it.
    piece: Piece,
    /// Its standard deviation in pixels.
    deviation: f64,
}

/// Fits those cylinders again that have a limb at the same edge of the image, so that none is the limb of two.
pub(super) fn settle(outcomes: &mut [Outcome], mut fit: impl FnMut(&[Task]) -> Vec<Outcome>) {
    let contests = contests(outcomes);
    let claims =
        contests.iter().flat_map(|contest| contest.cylinders.map(|cylinder| (cylinder, contest.piece)));
    let claimed = by_cylinder(outcomes.len(), claims);
    let contested = claimed.iter().enumerate().filter(|(_, pieces)| !pieces.is_empty());
    let tasks: Vec<Task> =
        contested.map(|(cylinder, pieces)| Task { cylinder, limbs_of_others: pieces.clone() }).collect();
    if tasks.is_empty() {
        return;
    }
    let mut without: Vec<Outcome> = outcomes.iter().map(|_| None).collect();
    for (task, outcome) in tasks.iter().zip(fit(&tasks)) {
        without[task.cylinder] = outcome;
    }
    let losses = contests.iter().flat_map(|contest| {
        let winner = contest.winner(&without);
        let losers = contest.cylinders.into_iter().filter(move |&cylinder| Some(cylinder) != winner);
        losers.map(|cylinder| (cylinder, contest.piece))
    });
    let lost = by_cylinder(outcomes.len(), losses);
    for (cylinder, pieces) in lost.into_iter().enumerate().filter(|(_, pieces)| !pieces.is_empty()) {
        let again = match pieces.len() == claimed[cylinder].len() {
            true => without[cylinder].take(),
            false => fit(&[Task { cylinder, limbs_of_others: pieces }]).pop().flatten(),
        };
        if let Some(Ok(_)) = again {
            outcomes[cylinder] = again;
        }
    }
}

/// Pieces by the cylinder that they go with.
fn by_cylinder(count: usize, pairs: impl Iterator<Item = (usize, Piece)>) -> Vec<Vec<Piece>> {
    let mut pieces = vec![Vec::new(); count];
    pairs.for_each(|(cylinder, piece)| pieces[cylinder].push(piece));
    pieces
}

/// All contests between cylinders of a scene.
fn contests(outcomes: &[Outcome]) -> Vec<Contest> {
    let claiming = |outcome| fitted(outcome).filter(|found| found.score >= CLAIMING.get());
    let limbs: Vec<Vec<Limb>> =
        outcomes.iter().map(|outcome| claiming(outcome).map_or_else(Vec::new, Limb::both)).collect();
    let mut contests = Vec::new();
    for (b, of_b) in limbs.iter().enumerate() {
        for (a, of_a) in limbs[..b].iter().enumerate() {
            let pairs = of_a.iter().flat_map(|first| of_b.iter().map(move |second| (first, second)));
            let shared = pairs.filter_map(|(first, second)| first.shared_with(second));
            contests.extend(shared.map(|(piece, deviation)| Contest { cylinders: [a, b], piece, deviation }));
        }
    }
    contests
}

fn fitted(outcome: &Outcome) -> Option<&Found> {
    Some(outcome.as_ref()?.as_ref().ok()?)
}

impl Contest {
    /// Whose limb the edge is, by the fits without it; `None` where that is not told.
    fn winner(&self, without: &[Outcome]) -> Option<usize> {
        let [a, b] = self.cylinders.map(|cylinder| {
            let surprise = fitted(&without[cylinder]).and_then(|found| self.surprise(found));
            surprise.unwrap_or(f64::INFINITY)
        });
        let least = 2.0 * ODDS.get().ln();
        match (a + least < b, b + least < a) {
            (true, _) => Some(self.cylinders[0]),
            (_, true) => Some(self.cylinders[1]),
            _ => None,
        }
    }

    /// −2 log of the probability density of a limb at the edge, by the fit of a cylinder without it: of its distance at both ends of
    /// the piece, which is normal with the covariance of the fit.
    fn surprise(&self, found: &Found) -> Option<f64> {
        let camera = found.fitter.camera()?;
        let into_camera = found.fitter.pose().inverse();
        let distances =
            |cylinder: &Cylinder| camera.distances_from_limbs(&into_camera.cylinder(cylinder), &self.piece);
        let both = distances(&found.result.cylinder)?;
        let limb = usize::from(both[1].norm() < both[0].norm());
        let uncertainty = found.result.uncertainty.as_ref()?;
        let of_fit = uncertainty.propagate(|cylinder| Some(distances(cylinder)?[limb]))?;
        let covariance = of_fit + Matrix2::identity() * self.deviation.powi(2);
        let squared = both[limb].dot(&(covariance.try_inverse()? * both[limb]));
        Some(squared + covariance.determinant().ln())
    }
}

/// A limb of a cylinder in the image.
struct Limb {
    /// The piece along which it is seen; the body is on its left.
    piece: Piece,
    /// Its standard deviation in pixels.
    deviation: f64,
    /// Whether it was located in the image.
    located: bool,
    /// What is nearer than this is the same edge.
    same: f64,
}

impl Limb {
    /// The limbs of a cylinder; none where there is no camera.
    fn both(found: &Found) -> Vec<Self> {
        [0, 1].into_iter().filter_map(|number| Self::new(found, number)).collect()
    }

    /// The limb of this number, in the order of [`LimbFrame::limb_lines`].
    fn new(found: &Found, number: usize) -> Option<Self> {
        let camera = found.fitter.camera()?;
        let noise = found.fitter.options().noise.in_image(camera.size());
        let same = noise.same_limb();
        let into_camera = found.fitter.pose().inverse();
        let cylinder = into_camera.cylinder(&found.result.cylinder);
        let extent = found.extent.as_ref().ok()?;
        // A line that contradicts the points has no part in the fit.
        let is_followed = |limb: &&LimbObservation| {
            let distances =
                limb.line.ok().and_then(|line| camera.distances_from_limbs(&cylinder, &line.ends));
            distances.is_some_and(|distances| distances[number].amax() <= same)
        };
        let located = found.limbs().into_iter().flatten().find(is_followed);
        let located = located.and_then(|limb| Some((limb.seen()?, limb.line.ok()?.sigma)));
        let of_fit = || {
            let limb = LimbFrame::new(&cylinder)?.limb_lines()[number];
            let beside =
                |point: &Vector3<f64>| camera.ideal_pixel(&limb.nearest_to(&into_camera.point(point)));
            Some(([beside(&extent.start)?, beside(&extent.end)?], noise.side))
        };
        let ([first, last], deviation) = located.or_else(of_fit)?;
        let body = camera.ideal_pixel(&into_camera.point(&extent.center))?;
        let is_left = (last - first).perp(&(body - first)) > 0.0;
        let piece = if is_left { [first, last] } else { [last, first] };
        Some(Self { piece, deviation, located: located.is_some(), same })
    }

    /// The piece of an edge of the image that is the limb of a body on the other side, too, and its standard deviation.
    fn shared_with(&self, other: &Self) -> Option<(Piece, f64)> {
        let [first, last] = self.piece;
        let length = (last - first).norm();
        let along = (last - first) / length;
        // The other one runs the other way, as its body is on its left.
        let [other_last, other_first] = other.piece;
        let [from, to] = [other_first, other_last].map(|q| along.dot(&(q - first)));
        let both = [from.max(0.0), to.min(length)];
        let enough = both[1] - both[0] >= OVERLAP.get() * length.min(to - from);
        if !enough || !(self.located || other.located) {
            return None;
        }
        let own = both.map(|position| first + along * position);
        let of_other = both.map(|position| other_first.lerp(&other_last, (position - from) / (to - from)));
        let same = own.iter().zip(&of_other).all(|(p, q)| (p - q).norm() <= self.same);
        let better = match self.deviation < other.deviation {
            true => (own, self.deviation),
            false => (of_other, other.deviation),
        };
        same.then_some(better)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limb(ends: [[f64; 2]; 2], located: bool) -> Limb {
        let deviation = if located { 0.1 } else { 1.6 };
        Limb { piece: ends.map(|[x, y]| Vector2::new(x, y)), deviation, located, same: 1.0 }
    }

    #[test]
    fn an_edge_between_two_bodies_is_shared_where_both_see_it() {
        let upper = limb([[100.0, 50.0], [300.0, 50.0]], true);
        let lower = limb([[400.0, 50.8], [200.0, 50.8]], false);
        let (piece, deviation) = upper.shared_with(&lower).unwrap();
        assert_eq!(piece, [Vector2::new(200.0, 50.0), Vector2::new(300.0, 50.0)]);
        assert_eq!(deviation, 0.1);
        let (piece, deviation) = lower.shared_with(&upper).unwrap();
        assert_eq!(piece, [Vector2::new(300.0, 50.0), Vector2::new(200.0, 50.0)]);
        assert_eq!(deviation, 0.1);
    }

    #[test]
    fn other_limbs_are_not_one_edge() {
        let upper = limb([[100.0, 50.0], [300.0, 50.0]], true);
        let not_shared = |ends: [[f64; 2]; 2]| upper.shared_with(&limb(ends, true)).is_none();
        assert!(not_shared([[200.0, 50.8], [400.0, 50.8]]), "a body on the same side");
        assert!(not_shared([[450.0, 50.0], [250.0, 50.0]]), "seen beside each other for a quarter of it");
        assert!(not_shared([[600.0, 50.0], [400.0, 50.0]]), "apart along the line");
        assert!(not_shared([[300.0, 51.2], [100.0, 50.0]]), "turned away");
        let found_by_depth = limb([[300.0, 50.0], [100.0, 50.0]], false);
        assert!(found_by_depth.shared_with(&found_by_depth).is_none(), "no edge of the image");
    }
}

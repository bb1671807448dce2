//! Mean, size and covariance of a cloud, and the sums over its points that its moments are made of.

use nalgebra::{Matrix3, SMatrix, Vector3};

/// Points that are added up before their sum joins the total, which keeps the rounding of millions small.
const BLOCK: usize = 1024;

/// The cloud counts as flat when its smallest variance is below this part of its largest: far below the
/// flattest arc whose curvature survives the rounding of the moments.
const FLAT_VARIANCE: f64 = 1e-13;

/// Where points lie and how far they spread, without the moments.
#[derive(Debug, Clone, Copy)]
pub struct Spread {
    /// Their weighted mean.
    pub center: Vector3<f64>,
    /// Their weighted root mean square distance from it.
    pub size: f64,
}

impl Spread {
    /// That of points with weights; `None` where they have no [`Moments`](super::Moments).
    #[must_use]
    pub fn new(points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone) -> Option<Self> {
        let spread = Self::unchecked(points.clone())?;
        let gram = about(points, spread.center, spread.size, linear_monomials)?;
        (!is_flat(&covariance(&gram))).then_some(spread)
    }

    /// The same of points that may lie in one plane.
    pub(super) fn unchecked(points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone) -> Option<Self> {
        let points = usable(points);
        // About the first point, which is near the others wherever the cloud is.
        let (reference, _) = points.clone().next()?;
        let mut count = 0_usize;
        let (mut weights, mut first, mut second) = (0.0, Vector3::zeros(), 0.0);
        for (p, weight) in points {
            let q = p - reference;
            count += 1;
            weights += weight;
            first += q * weight;
            second += q.norm_squared() * weight;
        }
        let mean = first / weights;
        let size = (second / weights - mean.norm_squared()).sqrt();
        let determined = count >= 5 && size > 0.0 && size.is_finite();
        determined.then_some(Self { center: reference + mean, size })
    }
}

/// The points with finite coordinates and a positive, finite weight.
fn usable(
    points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone,
) -> impl Iterator<Item = (Vector3<f64>, f64)> + Clone {
    points.filter(|(p, weight)| p.iter().all(|x| x.is_finite()) && *weight > 0.0 && weight.is_finite())
}

/// The covariance by the mean products of 1, x, y and z.
pub(super) fn covariance(gram: &SMatrix<f64, 4, 4>) -> Matrix3<f64> {
    let mean = gram.fixed_view::<3, 1>(1, 0).into_owned();
    gram.fixed_view::<3, 3>(1, 1) - mean * mean.transpose()
}

/// Whether points with a covariance lie in one plane or on one line to rounding.
pub(super) fn is_flat(covariance: &Matrix3<f64>) -> bool {
    let variances = covariance.symmetric_eigenvalues();
    !(variances.min() > FLAT_VARIANCE * variances.max())
}

/// The monomials up to degree one at q.
fn linear_monomials(q: &Vector3<f64>) -> [f64; 4] {
    [1.0, q.x, q.y, q.z]
}

/// The weighted mean of m mᵀ for monomials m of q = (p − center) / unit; `None` where a number of it is not finite.
///
/// With all ten its upper triangle has 55 entries but only 35 of them differ; adding up those alone is slower, because they
/// don't lie in rows.
pub(super) fn about<const N: usize>(
    points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone,
    center: Vector3<f64>,
    unit: f64,
    monomials: impl Fn(&Vector3<f64>) -> [f64; N],
) -> Option<SMatrix<f64, N, N>> {
    let mut total = [[0.0; N]; N];
    let mut block = [[0.0; N]; N];
    let mut weights = 0.0;
    let flush = |total: &mut [[f64; N]; N], block: &mut [[f64; N]; N]| {
        for (t, b) in total.as_flattened_mut().iter_mut().zip(block.as_flattened_mut()) {
            *t += std::mem::take(b);
        }
    };
    for (n, (p, weight)) in usable(points).enumerate() {
        if n % BLOCK == 0 {
            flush(&mut total, &mut block);
        }
        weights += weight;
        let m = monomials(&((p - center) / unit));
        for i in 0..N {
            let scaled = weight * m[i];
            for j in i..N {
                block[i][j] += scaled * m[j];
            }
        }
    }
    flush(&mut total, &mut block);
    let gram = SMatrix::<f64, N, N>::from_fn(|i, j| total[i.min(j)][i.max(j)]) / weights;
    gram.iter().all(|x| x.is_finite()).then_some(gram)
}

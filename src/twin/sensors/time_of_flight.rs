//! Time of flight: modulated light, and the phase with which it comes back.
//!
//! A pixel sums the light of all that it sees as phasors A exp(i 4π f d / c) of distance d, at each modulation frequency
//! f. So a pixel across an edge measures a distance between both sides or, by interference, none of them: flying pixels
//! come by themselves (Keller, Kolb, "Real-time simulation of time-of-flight sensors", Simulation Modelling Practice and
//! Theory 17(5), 2009). A share of all light is scattered widely in the lens (Mure-Dubois, Hügli, "Real-time scattering
//! compensation for time-of-flight camera", ICVS workshop 2007). The noise is that of the electrons: σ_d = c / (4π f) ·
//! σ / A, where both components of the phasor have the variance (signal + other light + read noise²) / 2 (Lange, Seitz,
//! "Solid-state time-of-flight range camera", IEEE Journal of Quantum Electronics 37(3), 2001). Which period it was
//! follows from the frequencies together (as in Bamji et al., IEEE Journal of Solid-State Circuits 50(1), 2015).

use crate::observations::DepthCamera;
use crate::twin::random::{Purpose, Stream};
use crate::twin::sampling::{Key, Sample, blur, mean_over_pixels};
use crate::twin::scene::{Scene, Viewpoint};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// Metres a second.
const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// Modulation frequencies in Hz; the last one is the highest.
const FREQUENCIES: [f64; 3] = [60e6, 80e6, 100e6];

/// Periods of the highest frequency until all of them repeat, at 7.5 m.
const PERIODS: u32 = 5;

/// Real and imaginary part for each frequency, and the light.
type Phasors = [f64; 7];

/// Side of the cells in pixels in which scattered light is computed.
const CELL: usize = 8;

/// A continuous-wave time-of-flight sensor whose lamp is beside its lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeOfFlight {
    /// The depths that it measures, in metres.
    pub range: [f64; 2],
    /// Electrons from a white surface at 1 m.
    pub electrons: f64,
    /// Electrons of other light.
    pub ambient: f64,
    /// Noise of reading a pixel out, in electrons.
    pub read_noise: f64,
    /// The share of light that the lens scatters widely.
    pub scatter: f64,
    /// How wide, as a standard deviation in pixels.
    pub scatter_width: f64,
    /// The least signal, in standard deviations of its noise.
    pub least_signal: f64,
    /// Standard deviation of the smoothing filter in pixels, which spares edges (Tomasi, Manduchi, ICCV 1998); 0 for
    /// none.
    pub smoothing: f64,
}

impl Default for TimeOfFlight {
    fn default() -> Self {
        Self {
            range: [0.2, 5.0],
            electrons: 30_000.0,
            ambient: 4000.0,
            read_noise: 40.0,
            scatter: 0.02,
            scatter_width: 60.0,
            least_signal: 12.0,
            smoothing: 1.2,
        }
    }
}

impl TimeOfFlight {
    /// The depth of each pixel in metres, row by row; 0 where none was measured.
    pub(super) fn measure(&self, scene: &Scene, own: &DepthCamera, seed: u64) -> Vec<f32> {
        let size = own.camera.size();
        let mut phasors = self.phasors(scene, own);
        self.scatter_light(&mut phasors, size);
        let mut noise = Stream::new(seed, Purpose::Sensor);
        let measured: Vec<Option<Measured>> =
            phasors.iter().map(|phasors| self.distance(phasors, &mut noise)).collect();
        let depth = |(k, distance): (usize, Option<f64>)| {
            let pixel = Vector2::new((k % size.0) as f64, (k / size.0) as f64);
            let ray = own.camera.unproject(&pixel)?;
            let z = distance? / ray.norm();
            (z >= self.range[0] && z <= self.range[1]).then_some(z as f32)
        };
        self.smooth(&measured, size).into_iter().enumerate().map(|at| depth(at).unwrap_or(0.0)).collect()
    }

    /// The sum of what comes back to each pixel, in electrons.
    fn phasors(&self, scene: &Scene, own: &DepthCamera) -> Vec<Phasors> {
        let eye = Viewpoint::new(scene, *own.to_color.translation());
        let look = |x: f64, y: f64| {
            let nothing = Sample { key: Key::default(), values: [0.0; 7] };
            let Some(ray) = own.camera.unproject(&Vector2::new(x, y)) else { return nothing };
            let ray: Vector3<f64> = own.to_color.direction(&ray);
            let Some(hit) = eye.look(&ray) else { return nothing };
            let mut patch = eye.patch(&ray, &hit);
            // Most inks are clearer in the near infrared.
            patch.albedo = 0.25 + 0.65 * patch.albedo;
            let distance = ray.norm() * hit.t;
            let light =
                self.electrons * patch.reflect(eye.origin(), eye.origin()) / (distance * distance).max(0.01);
            let mut values = [0.0; 7];
            for (k, frequency) in FREQUENCIES.iter().enumerate() {
                let (sine, cosine) = libm::sincos(distance / unit_of_phase(*frequency));
                values[2 * k] = light * cosine;
                values[2 * k + 1] = light * sine;
            }
            values[6] = light;
            let key = Key { surface: Some((hit.body, hit.part)), lit: true, albedo: patch.albedo as f32 };
            Sample { key, values }
        };
        mean_over_pixels(own.camera.size(), look)
    }

    /// Gives a share of all light to pixels far around, computed on a coarse grid.
    fn scatter_light(&self, phasors: &mut [Phasors], (width, height): (usize, usize)) {
        if !(self.scatter > 0.0) {
            return;
        }
        let (columns, rows) = (width.div_ceil(CELL), height.div_ceil(CELL));
        let mut cells = vec![[0.0; 7]; columns * rows];
        for (k, phasor) in phasors.iter().enumerate() {
            let cell = &mut cells[(k / width / CELL) * columns + k % width / CELL];
            cell.iter_mut().zip(phasor).for_each(|(sum, value)| *sum += value);
        }
        let area = (CELL * CELL) as f64;
        cells.iter_mut().flatten().for_each(|sum| *sum /= area);
        blur(&mut cells, (columns, rows), self.scatter_width / CELL as f64);
        // Between the middles of cells, so that no step shows.
        let between = |index: usize, count: usize| {
            let at = ((index as f64 + 0.5) / CELL as f64 - 0.5).clamp(0.0, (count - 1) as f64);
            let first = libm::floor(at) as usize;
            (first, (first + 1).min(count - 1), at - first as f64)
        };
        for (k, phasor) in phasors.iter_mut().enumerate() {
            let (left, right, u) = between(k % width, columns);
            let (top, bottom, v) = between(k / width, rows);
            let corners = [(top, left), (top, right), (bottom, left), (bottom, right)];
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
            phasor.iter_mut().for_each(|own| *own *= 1.0 - self.scatter);
            for ((row, column), weight) in corners.into_iter().zip(weights) {
                let wide = &cells[row * columns + column];
                phasor.iter_mut().zip(wide).for_each(|(own, wide)| *own += self.scatter * weight * wide);
            }
        }
    }

    /// The distance by noisy phasors: the period is the one in which the frequencies agree best.
    fn distance(&self, phasors: &Phasors, noise: &mut Stream) -> Option<Measured> {
        let sigma = (0.5 * (phasors[6] + self.ambient + self.read_noise * self.read_noise)).sqrt();
        let mut phases = [0.0; 3];
        let mut signal = [0.0; 3];
        for k in 0..3 {
            let re = phasors[2 * k] + sigma * noise.normal();
            let im = phasors[2 * k + 1] + sigma * noise.normal();
            signal[k] = libm::hypot(re, im);
            phases[k] = libm::atan2(im, re);
        }
        if signal.iter().any(|signal| *signal < self.least_signal * sigma) {
            return None;
        }
        let mut best: Option<(f64, f64)> = None;
        let highest = unit_of_phase(FREQUENCIES[2]);
        let phase = if phases[2] < 0.0 { phases[2] + TAU } else { phases[2] };
        for period in 0..PERIODS {
            let first = highest * (phase + TAU * f64::from(period));
            // The distances that each frequency says, next to the first one, weighed by what a phase is worth there.
            let (mut sum, mut weights, mut squares) = (0.0, 0.0, 0.0);
            for k in 0..3 {
                let unit = unit_of_phase(FREQUENCIES[k]);
                let weight = (signal[k] / unit).powi(2);
                let off = unit * wrapped(phases[k] - first / unit);
                sum += weight * off;
                squares += weight * off * off;
                weights += weight;
            }
            let cost = squares - sum * sum / weights;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, first + sum / weights));
            }
        }
        let deviation = highest * sigma / signal[2];
        best.map(|(_, distance)| Measured { distance, deviation })
    }

    /// The bilateral filter: neighbours count by their distance in the image and in depth.
    fn smooth(&self, measured: &[Option<Measured>], (width, height): (usize, usize)) -> Vec<Option<f64>> {
        if !(self.smoothing > 0.0) {
            return measured.iter().map(|m| m.map(|m| m.distance)).collect();
        }
        let reach = libm::ceil(2.0 * self.smoothing) as usize;
        let near = |offset: usize| libm::exp(-0.5 * (offset as f64 / self.smoothing).powi(2));
        let weights: Vec<f64> = (0..=reach).map(near).collect();
        let value = |k: usize| {
            let own = measured[k]?;
            let (x, y) = (k % width, k / width);
            let scale = 0.5 / (9.0 * own.deviation * own.deviation);
            let (mut sum, mut total) = (0.0, 0.0);
            for v in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                for u in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                    let Some(other) = measured[v * width + u] else { continue };
                    let step = other.distance - own.distance;
                    let exponent = step * step * scale;
                    if exponent < 8.0 {
                        let weight = weights[x.abs_diff(u)] * weights[y.abs_diff(v)] * libm::exp(-exponent);
                        sum += weight * step;
                        total += weight;
                    }
                }
            }
            Some(own.distance + sum / total)
        };
        (0..measured.len()).map(value).collect()
    }
}

/// A distance and its standard deviation.
#[derive(Debug, Clone, Copy)]
struct Measured {
    distance: f64,
    deviation: f64,
}

/// The distance for which the phase grows by one radian: c / 4π f.
fn unit_of_phase(frequency: f64) -> f64 {
    SPEED_OF_LIGHT / (4.0 * PI * frequency)
}

/// An angle in [−π, π].
fn wrapped(angle: f64) -> f64 {
    angle - TAU * libm::round(angle / TAU)
}

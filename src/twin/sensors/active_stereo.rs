//! Active stereo: two infrared cameras, and a projector that gives texture to what has none.
//!
//! Both cameras see dots and scene; windows of the left image are looked for in the right one, and the way back must
//! lead to the same position (Keselman et al., "Intel RealSense stereoscopic depth cameras", CVPR workshops 2017). Depth is
//! f b / d, as for structured light; the noise of both images counts.

use super::infrared::{Infrared, Pattern};
use super::matching::{self, Matching, depths, disparities};
use crate::observations::DepthCamera;
use crate::twin::random::{Purpose, Stream};
use crate::twin::scene::Scene;

/// An active stereo sensor. The depth camera is the left one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveStereo {
    /// The distance between the cameras in metres; the projector is in the middle.
    pub baseline: f64,
    /// The depths that it measures, in metres.
    pub range: [f64; 2],
    /// Half of the side of a matching window in pixels, without its middle.
    pub half_window: usize,
    /// The least correlation.
    pub least_score: f32,
    /// The second best position must correlate less than this share of the best one.
    pub uniqueness: f32,
    /// Disparities are multiples of 1 / `steps` pixels.
    pub steps: f64,
    /// Smaller islands of depth are taken away, in pixels.
    pub least_island: usize,
    /// Half of the side of the median filter, without its middle; 0 for none.
    pub half_median: usize,
    /// Light from elsewhere, as a share of the light of a dot at 1 m.
    pub ambient: f64,
    /// Electrons of a pixel at full scale.
    pub full_well: f64,
    /// Noise of reading a pixel out, in electrons.
    pub read_noise: f64,
}

impl Default for ActiveStereo {
    fn default() -> Self {
        Self {
            baseline: 0.055,
            range: [0.35, 4.0],
            half_window: 4,
            least_score: 0.6,
            uniqueness: 0.9,
            steps: 32.0,
            least_island: 60,
            half_median: 1,
            ambient: 0.3,
            full_well: 6000.0,
            read_noise: 12.0,
        }
    }
}

impl ActiveStereo {
    /// The depth of each pixel in metres, row by row; 0 where none was measured.
    pub(super) fn measure(&self, scene: &Scene, own: &DepthCamera, seed: u64) -> Vec<f32> {
        let (width, height) = own.camera.size();
        let strength = own.camera.intrinsics().fx * self.baseline;
        let [least, most] = matching::range(strength, self.range);
        let margin = most + 1;
        let pattern = Pattern::new((width, height), margin, 5.0, 0.9, seed);
        let mut noise = Stream::new(seed, Purpose::Sensor);
        let mut image = |eye: f64| {
            let infrared = Infrared {
                scene,
                pattern: &pattern,
                own,
                eye,
                projector: 0.5 * self.baseline,
                ambient: self.ambient,
                full_well: self.full_well,
                read_noise: self.read_noise,
                // Both cameras see another one; the dots of such projectors are made of many modes, with little.
                speckle: 0.05,
            };
            infrared.image(&mut noise)
        };
        let left = image(0.0);
        let right = image(self.baseline);
        // Nothing is seen to the left of the right image.
        let mut padded = vec![0; (width + margin) * height];
        for (row, line) in right.chunks_exact(width).enumerate() {
            padded[row * (width + margin) + margin..][..width].copy_from_slice(line);
        }
        let matching = Matching {
            half: self.half_window,
            least,
            count: most - least + 1,
            least_score: self.least_score,
            uniqueness: self.uniqueness,
            both_ways: true,
            steps: self.steps,
        };
        let found = disparities(&left, &padded, (width, height), margin, &matching);
        depths(found, (width, height), self.least_island, self.half_median, strength)
    }
}

//! Structured light: a projector of dots, a camera beside it, block matching.
//!
//! The sensor sees its own pattern on the scene and looks for each pixel's window in the pattern as it was sent out
//! (Freedman et al., US patent 2010/0118123; simulated as in Landau, Choo, Beling, "Simulating Kinect infrared and depth
//! images", IEEE Transactions on Cybernetics 46(12), 2016). With focal length f in pixels and baseline b the depth is
//! z = f b / d; a disparity that is off by δ gives z² δ / f b (Khoshelham, Elberink, "Accuracy and resolution of Kinect
//! depth data for indoor mapping applications", Sensors 12(2), 2012, who found steps of 1/8 pixel). Where the projector
//! does not reach, no dot and no depth is; windows across an edge take the side with more contrast.

use super::infrared::{Infrared, Pattern};
use super::matching::{self, Matching, depths, disparities};
use crate::observations::DepthCamera;
use crate::twin::random::{Purpose, Stream};
use crate::twin::scene::Scene;

/// A structured-light sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StructuredLight {
    /// The distance from the camera to the projector, to its right, in metres.
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
    /// Mean distance of the dots, in pixels.
    pub dot_spacing: f64,
    /// Standard deviation of a dot, in pixels.
    pub dot_size: f64,
    /// Light from elsewhere, as a share of the light of a dot at 1 m.
    pub ambient: f64,
    /// Electrons of a pixel at full scale.
    pub full_well: f64,
    /// Noise of reading a pixel out, in electrons.
    pub read_noise: f64,
    /// Contrast of the laser's own speckle on a pixel.
    pub speckle: f64,
}

impl Default for StructuredLight {
    fn default() -> Self {
        Self {
            baseline: 0.075,
            range: [0.4, 4.0],
            half_window: 4,
            least_score: 0.55,
            uniqueness: 0.9,
            steps: 8.0,
            least_island: 60,
            half_median: 1,
            dot_spacing: 2.8,
            dot_size: 0.65,
            ambient: 0.1,
            full_well: 3000.0,
            read_noise: 15.0,
            speckle: 0.15,
        }
    }
}

impl StructuredLight {
    /// The depth of each pixel in metres, row by row; 0 where none was measured.
    pub(super) fn measure(&self, scene: &Scene, own: &DepthCamera, seed: u64) -> Vec<f32> {
        let size = own.camera.size();
        let strength = own.camera.intrinsics().fx * self.baseline;
        let [least, most] = matching::range(strength, self.range);
        let margin = most + 1;
        let pattern = Pattern::new(size, margin, self.dot_spacing, self.dot_size, seed);
        let infrared = Infrared {
            scene,
            pattern: &pattern,
            own,
            eye: 0.0,
            projector: self.baseline,
            ambient: self.ambient,
            full_well: self.full_well,
            read_noise: self.read_noise,
            speckle: self.speckle,
        };
        let image = infrared.image(&mut Stream::new(seed, Purpose::Sensor));
        let matching = Matching {
            half: self.half_window,
            least,
            count: most - least + 1,
            least_score: self.least_score,
            uniqueness: self.uniqueness,
            both_ways: false,
            steps: self.steps,
        };
        let found = disparities(&image, &pattern.reference(size), size, margin, &matching);
        depths(found, size, self.least_island, self.half_median, strength)
    }
}

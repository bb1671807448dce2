//! One cylinder before a wall or on a table.

use super::builder::{Builder, Cylindrical, random_ground, random_material};
use crate::error::Result;
use crate::twin::random::Stream;
use crate::twin::scene::{Scene, Style};
use nalgebra::Vector3;

pub fn scene(stream: &mut Stream) -> Result<Scene> {
    let distance = stream.between(0.55, 0.95);
    let mut room = Builder::new(distance, 0.0, 0.0)?;
    let lamp = Vector3::new(
        stream.between(-1.0, 1.0),
        -distance - stream.between(0.0, 0.6),
        stream.between(0.0, 1.5),
    );
    room.light(lamp, stream.between(0.25, 0.6));
    let style = [Style::Can, Style::Plain, Style::Open][stream.below(3)];
    let radius = stream.log_between(0.015, 0.06);
    let length = (radius * stream.between(2.5, 6.0)).clamp(0.06, 0.22);
    let cylinder = Cylindrical::random(style, radius, length, stream);
    let (sine, cosine) = libm::sincos(stream.between(0.0, std::f64::consts::PI));
    let (away, across) = libm::sincos(stream.between(-0.8, 0.8));
    let axis = Vector3::new(cosine * across, away, sine * across);
    let at = Vector3::new(stream.between(-0.1, 0.1), 0.0, stream.between(-0.07, 0.07));
    // Behind the farthest point of it.
    let wall = 0.5 * cylinder.whole() * away.abs() + cylinder.widest() + stream.between(0.01, 0.3);
    let tilt = Vector3::new(stream.between(-0.1, 0.1), -1.0, stream.between(-0.1, 0.1));
    let ground = random_ground(stream);
    room.plane(Vector3::new(0.0, wall + 0.05, 0.0), tilt, ground)?;
    room.cylinder(&cylinder, (at, axis), random_material(stream), None)?;
    Ok(room.scene)
}

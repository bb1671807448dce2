//! Everything but cylinders.

use super::builder::{Builder, random_ground};
use super::table::{ball, block, frustum, room};
use crate::error::Result;
use crate::twin::random::Stream;
use crate::twin::scene::Scene;
use nalgebra::Vector3;

pub fn scene(stream: &mut Stream, seed: u64) -> Result<Scene> {
    let mut room = room(stream)?;
    let kind = seed % 5;
    if kind == 3 {
        planes(&mut room, stream)?;
        return Ok(room.scene);
    }
    for _ in 0..5 + stream.below(5) {
        match if kind == 4 { stream.below(3) as u64 } else { kind } {
            0 => block(&mut room, stream)?,
            1 => ball(&mut room, stream)?,
            _ => frustum(&mut room, stream)?,
        }
    }
    if kind == 4 {
        planes(&mut room, stream)?;
    }
    Ok(room.scene)
}

/// Walls behind the table: a corner, or a slope.
fn planes(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    for side in [-1.0, 1.0] {
        let wall = random_ground(stream);
        let at = Vector3::new(side * stream.between(0.3, 0.5), 0.3, 0.0);
        let lean = stream.between(0.0, 0.5);
        room.plane(at, Vector3::new(-side, -stream.between(0.3, 1.5), lean), wall)?;
    }
    Ok(())
}

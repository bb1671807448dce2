//! Random scenes by a seed.

mod alike;
mod builder;
mod no_cylinders;
mod pipes;
mod single;
mod table;

use super::random::{Purpose, Stream};
use super::scene::Scene;
use crate::error::Result;

/// Kinds of random scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Cans, bars and tubes on a table, standing, lying, leaning, stacked, among boxes, spheres, frustums and bottles.
    Table,
    /// Long pipes before a wall, cut by the border, side by side, crossing.
    Pipes,
    /// Alike bodies that touch: piles of pipes, rods in a row, crossed layers, cans side by side.
    Alike,
    /// Boxes, spheres, frustums and planes, and no cylinder. What lies there follows from the seed modulo 5: boxes,
    /// spheres, frustums, planes, some of everything.
    NoCylinders,
    /// One cylinder before a wall or on a table.
    Single,
}

/// A random scene.
///
/// # Errors
/// Never for the numbers that are drawn; the constructors check them.
pub fn random_scene(kind: Kind, seed: u64) -> Result<Scene> {
    let mut stream = Stream::new(seed, Purpose::Layout);
    match kind {
        Kind::Table => table::scene(&mut stream),
        Kind::Pipes => pipes::scene(&mut stream),
        Kind::Alike => alike::scene(&mut stream),
        Kind::NoCylinders => no_cylinders::scene(&mut stream, seed),
        Kind::Single => single::scene(&mut stream),
    }
}

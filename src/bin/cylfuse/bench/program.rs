//! The Point Cloud Library, by a program of its own: `tests/cpp/bench_pcl.cpp`.

use crate::failure::Failure;
use cylfuse::geometry::Cylinder;
use nalgebra::Vector3;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The program.
pub struct Pcl {
    program: PathBuf,
}

impl Pcl {
    /// The program at a path.
    ///
    /// # Errors
    /// `FILE_NOT_READABLE`.
    pub fn new(program: &Path) -> Result<Self, Failure> {
        // A name without a folder would be sought elsewhere.
        let program = program.canonicalize().map_err(|error| Failure::not_readable(program, &error))?;
        Ok(Self { program })
    }

    /// The cylinder through a cloud: the program reads x, y, z of all points as 32-bit numbers and prints point,
    /// direction and radius.
    ///
    /// # Errors
    /// `PCL` with what went wrong.
    pub fn fit(&self, points: impl Iterator<Item = Vector3<f64>>) -> Result<Cylinder, Failure> {
        let said = |what: String| Failure { status: "PCL", message: what };
        let broken = |error: std::io::Error| said(format!("the program for PCL does not run: {error}"));
        let bytes: Vec<u8> =
            points.flat_map(|p| [p.x, p.y, p.z]).flat_map(|x| (x as f32).to_le_bytes()).collect();
        let mut child = Command::new(&self.program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(broken)?;
        if let Some(mut input) = child.stdin.take() {
            input.write_all(&bytes).map_err(broken)?;
        }
        let output = child.wait_with_output().map_err(broken)?;
        let text = String::from_utf8_lossy(&output.stdout);
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [px, py, pz, dx, dy, dz, radius] = numbers[..] else {
            return Err(said(format!("no cylinder of {} points", bytes.len() / 12)));
        };
        Ok(Cylinder::new(Vector3::new(px, py, pz), Vector3::new(dx, dy, dz), radius)?)
    }
}

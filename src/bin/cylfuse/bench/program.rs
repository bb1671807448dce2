//! Other libraries, each by a program of its own: `tests/cpp/bench_pcl.cpp`, `tests/cpp/bench_cgal.cpp`.

use crate::failure::Failure;
use cylfuse::geometry::Cylinder;
use nalgebra::Vector3;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A program that finds cylinders in a cloud by another library: it reads x, y, z of all points as 32-bit numbers and prints
/// point, direction and radius of each cylinder on a line.
pub struct Program {
    /// What the library is called.
    pub library: &'static str,
    path: PathBuf,
}

impl Program {
    /// The program at a path.
    ///
    /// # Errors
    /// `FILE_NOT_READABLE`.
    pub fn new(library: &'static str, path: &Path) -> Result<Self, Failure> {
        // A name without a folder would be sought elsewhere.
        let path = path.canonicalize().map_err(|error| Failure::not_readable(path, &error))?;
        Ok(Self { library, path })
    }

    /// The cylinder through a cloud.
    ///
    /// # Errors
    /// `OTHER_LIBRARY` with what went wrong.
    pub fn fit(&self, points: impl Iterator<Item = Vector3<f64>>) -> Result<Cylinder, Failure> {
        match self.run(&[], points)?[..] {
            [cylinder] => Ok(cylinder),
            ref all => Err(self.failure(&format!("{} cylinders where one was asked for", all.len()))),
        }
    }

    /// All cylinders of a scene, best first.
    ///
    /// # Errors
    /// `OTHER_LIBRARY` with what went wrong.
    pub fn detect(&self, points: impl Iterator<Item = Vector3<f64>>) -> Result<Vec<Cylinder>, Failure> {
        self.run(&["scene"], points)
    }

    fn failure(&self, what: &str) -> Failure {
        Failure {
            status: "OTHER_LIBRARY",
            message: format!("{}, {}: {what}", self.library, self.path.display()),
        }
    }

    fn run(
        &self,
        arguments: &[&str],
        points: impl Iterator<Item = Vector3<f64>>,
    ) -> Result<Vec<Cylinder>, Failure> {
        let broken = |error: std::io::Error| self.failure(&format!("the program does not run: {error}"));
        let bytes: Vec<u8> =
            points.flat_map(|p| [p.x, p.y, p.z]).flat_map(|x| (x as f32).to_le_bytes()).collect();
        let mut child = Command::new(&self.path)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(broken)?;
        if let Some(mut input) = child.stdin.take() {
            input.write_all(&bytes).map_err(broken)?;
        }
        let output = child.wait_with_output().map_err(broken)?;
        if !output.status.success() {
            return Err(self.failure(&format!("{} with {} points", output.status, bytes.len() / 12)));
        }
        let text = String::from_utf8_lossy(&output.stdout);
        let cylinder = |line: &str| {
            let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            let [px, py, pz, dx, dy, dz, radius] = numbers[..] else {
                return Err(self.failure(&format!("not point, direction and radius: {line}")));
            };
            Ok(Cylinder::new(Vector3::new(px, py, pz), Vector3::new(dx, dy, dz), radius)?)
        };
        text.lines().map(cylinder).collect()
    }
}

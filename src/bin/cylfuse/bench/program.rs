//! Other libraries, each by a program of its own: `tests/cpp/bench_pcl.cpp`, `tests/cpp/bench_cgal.cpp`.
//!
//! A program that does not work must not pass for a library that fails: an ending with an error, an output that is no list of
//! cylinders, or none within the time limit stops the bench. What a library finds no cylinder in is an empty output. So the
//! trial of a search of scenes cannot tell a program that never finds anything from a library that does not.

use super::trial;
use crate::failure::Failure;
use cylfuse::geometry::Cylinder;
use nalgebra::Vector3;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Between two looks whether a program that has closed its output has ended.
const PAUSE: Duration = Duration::from_millis(5);

/// A program that finds cylinders in a cloud by another library: it reads x, y, z of all points as 32-bit numbers and prints
/// point, direction and radius of each cylinder on a line.
pub struct Program {
    /// What the library is called.
    pub library: &'static str,
    path: PathBuf,
    limit: Duration,
}

/// What a program is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// The cylinder through all points.
    Fit,
    /// All cylinders of a scene.
    Scene,
}

impl Program {
    /// The program at a path, which has `limit` for each cloud.
    ///
    /// # Errors
    /// `FILE_NOT_READABLE`.
    pub fn new(library: &'static str, path: &Path, limit: Duration) -> Result<Self, Failure> {
        // A name without a folder would be sought elsewhere.
        let path = path.canonicalize().map_err(|error| Failure::not_readable(path, &error))?;
        Ok(Self { library, path, limit })
    }

    /// Tries the program on a small cloud of one cylinder.
    ///
    /// # Errors
    /// `OTHER_LIBRARY` where it does not do what it is asked for.
    pub fn try_out(&self, task: Task) -> Result<(), Failure> {
        let found = self.run(task, trial::points())?;
        match task {
            Task::Fit => trial::judge(&found).map_err(|what| self.failure(&what)),
            // A library may take a lone cylinder for a table.
            Task::Scene => Ok(()),
        }
    }

    /// The cylinder through a cloud; none where the library finds none.
    ///
    /// # Errors
    /// `OTHER_LIBRARY` with what went wrong.
    pub fn fit(&self, points: impl Iterator<Item = Vector3<f64>>) -> Result<Option<Cylinder>, Failure> {
        match self.run(Task::Fit, points)?[..] {
            [] => Ok(None),
            [cylinder] => Ok(Some(cylinder)),
            ref all => Err(self.failure(&format!("{} cylinders where one was asked for", all.len()))),
        }
    }

    /// All cylinders of a scene, best first.
    ///
    /// # Errors
    /// `OTHER_LIBRARY` with what went wrong.
    pub fn detect(&self, points: impl Iterator<Item = Vector3<f64>>) -> Result<Vec<Cylinder>, Failure> {
        self.run(Task::Scene, points)
    }

    fn failure(&self, what: &str) -> Failure {
        // What others print may have line breaks; a message is one line.
        let message = format!("{}, {}: {what}", self.library, self.path.display());
        Failure { status: "OTHER_LIBRARY", message: message.replace(char::is_control, " ") }
    }

    fn run(&self, task: Task, points: impl Iterator<Item = Vector3<f64>>) -> Result<Vec<Cylinder>, Failure> {
        let broken = |error: std::io::Error| self.failure(&format!("the program does not run: {error}"));
        let bytes: Vec<u8> =
            points.flat_map(|p| [p.x, p.y, p.z]).flat_map(|x| (x as f32).to_le_bytes()).collect();
        let count = bytes.len() / 12;
        let clock = Instant::now();
        let mut child = Command::new(&self.path)
            .args((task == Task::Scene).then_some("scene"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(broken)?;
        // Each on a thread of its own, so that no full pipe holds up another.
        if let Some(mut input) = child.stdin.take() {
            // A program that ends without reading says why by its status.
            thread::spawn(move || drop(input.write_all(&bytes)));
        }
        let (output, complaints) = (reader(child.stdout.take()), reader(child.stderr.take()));
        let left = || self.limit.saturating_sub(clock.elapsed());
        let output = output.recv_timeout(left()).ok();
        let status = match output {
            Some(_) => ended(&mut child, &left).map_err(broken)?,
            None => None,
        };
        let (Some(output), Some(status)) = (output, status) else {
            // It may have ended in between.
            let _ = child.kill();
            let _ = child.wait();
            return Err(self.failure(&format!(
                "not done with {count} points after {} seconds; --time-limit sets this limit",
                self.limit.as_secs_f64()
            )));
        };
        if !status.success() {
            let said = complaints.recv_timeout(left()).unwrap_or_default();
            let said = said.lines().map(str::trim).rfind(|line| !line.is_empty()).map(shortened);
            let said = said.map_or_else(String::new, |line| format!(": {line}"));
            return Err(self.failure(&format!("{status} with {count} points{said}")));
        }
        let cylinder = |line: &str| {
            let words = line.split_whitespace().map(str::parse::<f64>);
            let numbers = words.collect::<Result<Vec<f64>, _>>().unwrap_or_default();
            let [px, py, pz, dx, dy, dz, radius] = numbers[..] else {
                let what = "a line of its output is not point, direction and radius";
                return Err(self.failure(&format!("{what}: {}", shortened(line))));
            };
            Cylinder::new(Vector3::new(px, py, pz), Vector3::new(dx, dy, dz), radius).map_err(|error| {
                self.failure(&format!("a line of its output is no cylinder ({error}): {}", shortened(line)))
            })
        };
        output.lines().map(cylinder).collect()
    }
}

/// The text that a pipe gives, once it is closed.
fn reader(pipe: Option<impl Read + Send + 'static>) -> Receiver<String> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // What came before an error tells enough.
            let _ = pipe.read_to_end(&mut bytes);
        }
        // Nobody waits any more after the time limit.
        let _ = sender.send(String::from_utf8_lossy(&bytes).into_owned());
    });
    receiver
}

/// How a program that has closed its output ended; none where it did not in the time that is left.
fn ended(child: &mut Child, left: &dyn Fn() -> Duration) -> std::io::Result<Option<ExitStatus>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if left().is_zero() {
            return Ok(None);
        }
        thread::sleep(PAUSE.min(left()));
    }
}

/// The beginning of a line.
fn shortened(line: &str) -> &str {
    line.char_indices().nth(120).map_or(line, |(end, _)| &line[..end])
}

//! Runs the program and makes frames for it.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// What a run of the program left.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    /// The JSON objects on stdout, one a line.
    pub fn objects(&self) -> Vec<Value> {
        let parse = |line: &str| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        self.stdout.lines().map(parse).collect()
    }

    /// The only JSON object on stdout.
    pub fn object(&self) -> Value {
        let mut objects = self.objects();
        assert_eq!(objects.len(), 1, "{}{}", self.stdout, self.stderr);
        objects.remove(0)
    }
}

/// Runs the program. It must end by itself, not by a panic or a signal.
pub fn run<I: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = I>) -> Run {
    let output =
        Command::new(env!("CARGO_BIN_EXE_cylfuse")).args(arguments).stdin(Stdio::null()).output().unwrap();
    let stdout = String::from_utf8(output.stdout).unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    let code = output.status.code().unwrap_or_else(|| panic!("ended by a signal: {stderr}"));
    assert!(!stdout.contains("PANIC") && !stderr.contains("panicked"), "{stdout}{stderr}");
    Run { code, stdout, stderr }
}

/// `cylfuse fit --json` of one frame with options.
pub fn fit(frame: &Path, options: &[&str]) -> Run {
    let mut arguments: Vec<&std::ffi::OsStr> = vec!["fit".as_ref(), "--json".as_ref(), frame.as_ref()];
    arguments.extend(options.iter().map(|option| std::ffi::OsStr::new(*option)));
    run(arguments)
}

/// The result of a fit that must succeed.
pub fn fitted(frame: &Path, options: &[&str]) -> Value {
    let run = fit(frame, options);
    let object = run.object();
    assert!(run.code == 0 && object["error"].is_null(), "{options:?}: {object}");
    object
}

/// Checks that a fit fails with exit status 1 and a status, and that its message has all the fragments.
pub fn fails(frame: &Path, options: &[&str], status: &str, fragments: &[&str]) {
    let run = fit(frame, options);
    let object = run.object();
    assert_eq!(run.code, 1, "{object}");
    assert_eq!(object["error"]["status"], status, "{object}");
    let message = object["error"]["message"].as_str().unwrap();
    for fragment in fragments {
        assert!(message.contains(fragment), "no '{fragment}' in: {message}");
    }
    let keys: Vec<&String> = object.as_object().unwrap().keys().collect();
    assert_eq!(keys.len(), 2, "{object}");
}

/// A folder of the test data.
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames").join(name)
}

/// A copy of a frame that may be spoilt.
pub struct Copy {
    folder: TempDir,
    pub json: Value,
}

impl Copy {
    pub fn new() -> Self {
        Self::of("r40_a20_f0")
    }

    pub fn of(name: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for file in ["frame.json", "image.png", "depth.png", "mask.png"] {
            std::fs::copy(data(name).join(file), folder.path().join(file)).unwrap();
        }
        let json = serde_json::from_slice(&std::fs::read(folder.path().join("frame.json")).unwrap()).unwrap();
        Self { folder, json }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes the JSON as it is now, and gives the path of the frame file.
    pub fn write(&self) -> PathBuf {
        let path = self.path("frame.json");
        std::fs::write(&path, self.json.to_string()).unwrap();
        path
    }
}

/// Three numbers.
pub fn vector(value: &Value) -> [f64; 3] {
    assert_eq!(value.as_array().unwrap().len(), 3, "{value}");
    std::array::from_fn(|k| value[k].as_f64().unwrap())
}

/// An object without its times, which differ from run to run.
pub fn without_seconds(mut object: Value) -> Value {
    object.as_object_mut().unwrap().remove("seconds");
    object
}

//! What to fit: the files behind the paths of the command line, and a place for the results of each.

use crate::failure::Failure;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use walkdir::WalkDir;

/// One thing to fit.
#[derive(Debug, Clone)]
pub enum Input {
    /// A frame file.
    Frame(PathBuf),
    /// A point cloud file.
    Cloud(PathBuf),
    /// A folder in which no frame was found.
    Nothing(PathBuf, Failure),
}

impl Input {
    /// The path that stands for it in reports.
    pub fn path(&self) -> &Path {
        match self {
            Input::Frame(path) | Input::Cloud(path) | Input::Nothing(path, _) => path,
        }
    }

    /// A short name: that of the folder of a frame.json, else that of the file.
    fn name(&self) -> String {
        let path = self.path();
        let of_folder =
            matches!(self, Input::Frame(_)) && path.file_name().is_some_and(|n| n == "frame.json");
        let named = if of_folder { path.parent().and_then(Path::file_name) } else { path.file_stem() };
        let resolved = path.canonicalize().ok();
        // The folder of "frame.json" and "../frame.json" has a name only as an absolute path.
        let named = named.or_else(|| resolved.as_deref()?.parent()?.file_name());
        named.map_or("frame".into(), |name| name.to_string_lossy().into_owned())
    }
}

/// The clouds of files, or without any the frames, each with a folder for its results where there is one for all.
pub fn of(clouds: &[PathBuf], frames: &[PathBuf], out: Option<&Path>) -> Vec<(Input, Option<PathBuf>)> {
    let inputs = match clouds {
        [] => find_frames(frames),
        _ => clouds.iter().cloned().map(Input::Cloud).collect(),
    };
    match out.map(|out| output_folders(&inputs, out)) {
        Some(folders) => inputs.into_iter().zip(folders.into_iter().map(Some)).collect(),
        None => inputs.into_iter().map(|input| (input, None)).collect(),
    }
}

/// The frames of files and folders, folders searched for frame.json in the order of names.
pub fn find_frames(paths: &[PathBuf]) -> Vec<Input> {
    paths.iter().flat_map(|path| if path.is_dir() { search(path) } else { vec![frame(path)] }).collect()
}

fn frame(path: &Path) -> Input {
    Input::Frame(path.to_path_buf())
}

fn search(folder: &Path) -> Vec<Input> {
    let mut inputs = Vec::new();
    for entry in WalkDir::new(folder).follow_links(true).sort_by_file_name() {
        match entry {
            Ok(entry) if entry.file_name() == "frame.json" && entry.file_type().is_file() => {
                inputs.push(frame(entry.path()));
            }
            Ok(_) => {}
            // A link back to a folder above it leads to nothing new.
            Err(error) if error.loop_ancestor().is_some() => {}
            Err(error) => {
                let path = error.path().unwrap_or(folder).to_path_buf();
                let failure = Failure::not_readable(&path, &error.into());
                inputs.push(Input::Nothing(path, failure));
            }
        }
    }
    if inputs.is_empty() {
        inputs.push(Input::Nothing(folder.to_path_buf(), Failure::no_frames(folder)));
    }
    inputs
}

/// The folder for the results of each input: `out` itself for a single one, else subfolders of different names.
fn output_folders(inputs: &[Input], out: &Path) -> Vec<PathBuf> {
    if inputs.len() == 1 {
        return vec![out.to_path_buf()];
    }
    let names: Vec<String> = inputs.iter().map(Input::name).collect();
    // Some file systems do not tell upper from lower case.
    let mut taken: HashSet<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let mut first_of_its_name = HashSet::new();
    let mut folders = Vec::new();
    for name in &names {
        let mut unique = name.clone();
        if !first_of_its_name.insert(name.to_lowercase()) {
            let mut number = 2;
            while !taken.insert(unique.to_lowercase()) {
                unique = format!("{name}-{number}");
                number += 1;
            }
        }
        folders.push(out.join(unique));
    }
    folders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_folders_never_collide() {
        let inputs: Vec<Input> =
            ["a/x/frame.json", "b/x/frame.json", "b/x-2/frame.json", "c/X/frame.json", "c/other.json"]
                .iter()
                .map(|path| frame(Path::new(path)))
                .collect();
        let folders = output_folders(&inputs, Path::new("out"));
        let names: Vec<_> =
            folders.iter().map(|f| f.strip_prefix("out").unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["x", "x-3", "x-2", "X-4", "other"]);
        assert_eq!(output_folders(&inputs[..1], Path::new("out")), [Path::new("out")]);
    }
}

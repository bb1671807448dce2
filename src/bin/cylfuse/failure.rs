//! What can go wrong with one frame or cloud.

use cylfuse::error::Error;
use serde::Serialize;
use std::fmt::{self, Display};
use std::path::Path;

/// Why there is no result, as it stands in the JSON output.
#[derive(Debug, Clone, Serialize)]
pub struct Failure {
    /// A name that programs can rely on: one of the library's or of those below.
    pub status: &'static str,
    /// What is wrong, which value, which limit, what to do.
    pub message: String,
}

impl Failure {
    /// A file cannot be opened or read at all.
    pub fn not_readable(path: &Path, error: &std::io::Error) -> Self {
        Self::file("FILE_NOT_READABLE", path, format!("cannot be read: {error}"))
    }

    /// A file or folder cannot be made.
    pub fn not_writable(path: &Path, error: impl Display) -> Self {
        let remedy = "name a place in a folder that exists and may be written to";
        Self::file("FILE_NOT_WRITABLE", path, format!("cannot be written: {error}; {remedy}"))
    }

    /// A folder without any frame.
    pub fn no_frames(path: &Path) -> Self {
        Self::file(
            "NO_FRAMES",
            path,
            "has no frame.json in it or below; name a folder of frames, or write the file: cylfuse fit --help shows one",
        )
    }

    /// A frame file is not what it should be.
    pub fn bad_frame(path: &Path, reason: impl Display) -> Self {
        Self::file("BAD_FRAME", path, reason)
    }

    /// An image file is damaged or of another kind than its role needs.
    pub fn bad_image(path: &Path, reason: impl Display) -> Self {
        Self::file("BAD_IMAGE", path, reason)
    }

    /// The header of an image promises more pixels than any camera has, or its file has more bytes than they take.
    pub fn image_too_large(path: &Path, reason: impl Display) -> Self {
        Self::file("IMAGE_TOO_LARGE", path, reason)
    }

    /// Two images that share one pixel grid have different sizes.
    pub fn size_mismatch(path: &Path, reason: impl Display) -> Self {
        Self::file("SIZE_MISMATCH", path, reason)
    }

    /// A point cloud file is damaged or of an unknown kind.
    pub fn bad_cloud(path: &Path, reason: impl Display) -> Self {
        Self::file("BAD_CLOUD", path, reason)
    }

    /// A mistake in this program: one frame must not take the others down with it.
    pub fn panic(payload: &(dyn std::any::Any + Send)) -> Self {
        let text = payload.downcast_ref::<&str>().copied();
        let text = text.or(payload.downcast_ref::<String>().map(String::as_str));
        let message = format!("internal error: {}; please report it", text.unwrap_or("no message"));
        Self { status: "PANIC", message }
    }

    /// The same, said of a location in a frame file.
    pub fn in_frame(self, path: &Path, location: &str) -> Self {
        Self::file(self.status, path, format!("{location}: {}", self.message))
    }

    /// The same, with what else may be the cause.
    pub fn with(mut self, remarks: &[String]) -> Self {
        for remark in remarks {
            self.message += "; ";
            self.message += remark;
        }
        self
    }

    fn file(status: &'static str, path: &Path, reason: impl Display) -> Self {
        // Parsers quote what they found, line breaks included; a message is one line.
        let line = format!("{}: {reason}", path.display()).replace(char::is_control, " ");
        Self { status, message: line }
    }
}

/// What is wrong, where options have the names of the command line.
pub fn in_words(error: &Error) -> String {
    match error {
        Error::InvalidArgument { name, value, requirement } if name.starts_with("options.") => {
            let flag = name.replacen("options.", "--", 1).replacen("--noise.", "--noise ", 1);
            format!("{} is {value}; it must {requirement}", flag.replace('_', "-"))
        }
        _ => error.to_string(),
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.status, self.message)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self { status: error.name(), message: in_words(&error) }
    }
}
